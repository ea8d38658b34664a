"""Codes of the reasons for rejection, and how often each occurs."""

from collections import Counter

from hbench.records import Results


def reason_counts(results: Results) -> Counter[str]:
    """Count the runs of each reason's code; a run with two reasons counts under both."""
    codes = (dict.fromkeys(map(code_of, run.reasons)) for run in results.runs)
    return Counter(code for run_codes in codes for code in run_codes)


def code_of(reason: str) -> str:
    """Return the code in "code: words with value and limit"."""
    return reason.partition(":")[0].strip()

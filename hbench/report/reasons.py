"""Why runs were rejected: the codes of the reasons and how often each occurs."""

from collections import Counter

from hbench.records import Results


def reason_counts(results: Results) -> Counter[str]:
    """Count the codes of the reasons; a run with two reasons counts under both."""
    return Counter(code_of(reason) for run in results.runs for reason in run.reasons)


def code_of(reason: str) -> str:
    """Return the code in "code: words with value and limit"."""
    return reason.partition(":")[0].strip()

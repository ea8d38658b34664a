"""Heading of the page of a diagnosis: its verdict as a title, and what was measured."""

from hbench.records import Diagnosis
from hbench.report.campaign.settings import provenance_facts
from hbench.report.diagnosis.names import in_words
from hbench.sentences import capital, listed

_SIZES = {"bore": "piston_diameter", "rod": "rod_diameter", "stroke": "stroke"}  # of a model file


def title_words(diagnosis: Diagnosis) -> str:
    """Return the title: the verdict in a few words, and the campaign."""
    return f"{_verdict(diagnosis)}: {diagnosis.provenance.name}"


def subtitle_words(diagnosis: Diagnosis) -> str:
    """Return what was compared."""
    return f"Model {diagnosis.model} against measured runs of {diagnosis.provenance.name}"


def _verdict(diagnosis: Diagnosis) -> str:
    if diagnosis.verdict == "named":
        sure = [in_words(effect.name) for effect in diagnosis.effects if effect.confirmed]
        others = [in_words(effect.name) for effect in diagnosis.effects if not effect.confirmed]
        parts = [
            *([f"{listed(sure)} found"] if sure else []),
            *([f"{listed(others)} not confirmed"] if others else []),
        ]
        return capital(", ".join(parts))
    if diagnosis.verdict == "ambiguous":
        names = [in_words(candidate.name) for candidate in diagnosis.alternatives]
        return f"{capital(listed(names, 'or'))}, not distinguishable"
    if diagnosis.verdict == "none":
        return "No missing effect found"
    return "Unknown deviation" if diagnosis.where else "Too few data for a verdict"


def identity_facts(diagnosis: Diagnosis) -> tuple[tuple[str, str], ...]:
    """Return what was compared, where and when it was measured, and by which version."""
    cylinder = diagnosis.revised.get("test_cylinder", {})
    sizes = [f"{name} {cylinder[key]}" for name, key in _SIZES.items() if key in cylinder]
    return (
        ("Model", diagnosis.model),
        ("Campaign", diagnosis.provenance.name),
        *provenance_facts(diagnosis.provenance, ", ".join(sizes)),
    )

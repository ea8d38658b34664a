"""Heading of the page of a diagnosis: its verdict as a title, and what was measured."""

from hbench.records import Diagnosis
from hbench.report.campaign.sections.settings import provenance_facts
from hbench.report.diagnosis.names import in_words
from hbench.sentences import capital, counted, listed

_LONGEST = 60  # letters of the names of effects in a title
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
        words = ", ".join(parts)
        if len(words) > _LONGEST and len(diagnosis.effects) > 1:
            words = _counted(len(sure), len(others))
        return capital(words)
    if diagnosis.verdict == "ambiguous":
        return f"{capital(_either(diagnosis))}, not distinguishable"
    if diagnosis.verdict == "none":
        return "No missing effect found"
    return "Unknown deviation" if diagnosis.where else "Too few data for a verdict"


def _either(diagnosis: Diagnosis) -> str:
    """Return the effects of the ambiguous sets, or how many there are of each."""
    sets = [[in_words(each.name) for each in some] for some in diagnosis.alternative_sets]
    either = ", and ".join(listed(names, "or") for names in sets)
    if len(either) <= _LONGEST:
        return either
    first, *others = map(len, sets)
    return ", and ".join([f"one of {first} effects", *(f"one of {n} others" for n in others)])


def _counted(sure: int, others: int) -> str:
    """Return how many effects were found; the verdict below the title names them."""
    effects = counted(sure or others, "effect")
    if not others or not sure:
        return f"{effects} {'found' if sure else 'not confirmed'}"
    return f"{effects} found, {others} not confirmed"


def identity_facts(diagnosis: Diagnosis) -> tuple[tuple[str, str], ...]:
    """Return what was compared, where and when it was measured, and by which version."""
    cylinder = diagnosis.revised.get("test_cylinder", {})
    sizes = [f"{name} {cylinder[key]}" for name, key in _SIZES.items() if key in cylinder]
    return (
        ("Model", diagnosis.model),
        ("Campaign", diagnosis.provenance.name),
        *provenance_facts(diagnosis.provenance, ", ".join(sizes)),
    )

"""What a comparison is of: both campaigns, their instruments, oil and data."""

from hbench.records import KINDS, CampaignDifferences
from hbench.report.campaign.quality.verdict import quality_verdict
from hbench.report.comparison.settings import SERIAL, plants_words
from hbench.report.oil_words import range_words
from hbench.sentences import sentences


def identity_facts(differences: CampaignDifferences) -> tuple[tuple[str, str], ...]:
    """Return both campaigns, and whether they share simulated plant and instruments."""
    plants = plants_words(differences)
    return (
        ("A", _name(differences, 0)),
        ("B", _name(differences, 1)),
        *((("Simulated plants", plants),) if plants else ()),
        ("Instruments", _instruments(differences)),
        *_oil(differences),
    )


def _oil(differences: CampaignDifferences) -> tuple[tuple[str, str], ...]:
    """Return the oil temperatures of the steady runs; nothing without such runs."""
    if not any(KINDS[curve.a.kind].has_constant_speed for curve in differences.curves):
        return ()
    if not any(differences.oil_temperatures):
        return (("Oil temperature", "Not measured in either campaign."),)
    each = "; ".join(
        f"{name}: {range_words(oil)}"
        for name, oil in zip("AB", differences.oil_temperatures, strict=True)
    )
    return (
        (
            "Oil temperature",
            f"{each}. Friction is compared at these temperatures, without a correction.",
        ),
    )


def data_facts(differences: CampaignDifferences) -> tuple[tuple[str, str], ...]:
    """Return the verdict on the data of each campaign, whose numbers are on its own page."""
    a, b = (quality_verdict(quality, below=False) for quality in differences.qualities)
    return (("Data of A and B", a),) if a == b else _apart(a, b)


def _apart(a: str, b: str) -> tuple[tuple[str, str], ...]:
    """Return what two verdicts have in common, and what differs; sentence by sentence."""
    of_a, of_b = (sentences(words) for words in (a, b))
    common = [each for each in of_a if each in of_b]
    parts = (
        ("Data of A and B", common),
        ("Data of A", [each for each in of_a if each not in common]),
        ("Data of B", [each for each in of_b if each not in common]),
    )
    return tuple((name, " ".join(each)) for name, each in parts if each)


def _instruments(differences: CampaignDifferences) -> str:
    means = [each.mean_n for each in differences.curves if each.mean_n is not None]
    tested = [*means, *(each.breakaway_n for each in differences.breakaways)]
    if all(each.u95 is None for each in tested):
        return (
            "No interval contains the instruments: their tolerances are not known, or a point has "
            "one trial."
        )
    if differences.same_instruments:
        return "Same instruments: their errors are in both, and cancel where the readings agree."
    return "Other instruments in each, or not known to be the same: the errors of both count."


def _name(differences: CampaignDifferences, which: int) -> str:
    campaign = (differences.a, differences.b)[which]
    labels = {(curve.a, curve.b)[which].label for curve in differences.curves}
    label = labels.pop() if len(labels) == 1 else ""
    day = campaign.started[:10].replace("-", "\N{NON-BREAKING HYPHEN}")
    schedule = f"schedule {campaign.name}"
    section, key = SERIAL
    serial = campaign.settings.get(section, {}).get(key, "")
    cylinder = f"cylinder {serial}" if serial and serial != differences.names[which] else ""
    words = (differences.names[which], cylinder, schedule, label, campaign.source, day)
    return ", ".join(filter(None, words))

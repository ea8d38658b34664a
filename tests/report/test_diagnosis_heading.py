"""The heading of a diagnosis's page."""

import re
from dataclasses import replace

from hbench.report.diagnosis.page import diagnosis_page
from tests.support.reconcile import made_diagnosis as made
from tests.support.report.spaces import breakable


def test_the_title_states_the_verdict_and_a_block_what_was_measured_where_and_when():
    named, unknown, ambiguous = made.named(), made.unknown(), made.ambiguous()

    def title(diagnosis):
        page = diagnosis_page(diagnosis, ())
        (text,) = re.findall(r"<h1>(.*)</h1>", page)
        assert f"<title>{text} (simulated)</title>" in page
        return text

    compared = "made &lt;up&gt;"
    assert title(named) == f"Internal leakage found: {compared}"
    assert title(unknown) == f"Unknown deviation: {compared}"
    assert title(replace(unknown, verdict="none", rest=())).startswith("No missing effect found: ")
    assert title(replace(unknown, where=(), rest=())).startswith("Too few data for a verdict: ")
    either = "Internal leakage or external leakage, not distinguishable"
    assert title(ambiguous) == f"{either}: {compared}"
    (effect,) = named.effects
    other = replace(effect, name="load_cell_gain", gap_after=effect.gap_before)
    both = replace(named, effects=(effect, other))
    assert title(both).startswith("Internal leakage found, load cell gain not confirmed: ")
    long = "an_effect_of_the_users_own_whose_name_does_not_fit"
    several = [effect, replace(effect, name="load_cell_gain"), replace(effect, name=long)]
    assert title(replace(both, effects=tuple(several))) == f"3 effects found: {compared}"
    several[2] = replace(other, name=long)
    words = title(replace(both, effects=tuple(several)))
    assert words == f"2 effects found, 1 not confirmed: {compared}"
    unsure = replace(effect, name=long, gap_after=effect.gap_before)
    assert title(replace(both, effects=(unsure, other))).startswith("2 effects not confirmed: ")
    assert title(replace(both, effects=(unsure,))).startswith("An effect of the users own whose ")
    far = tuple(replace(each, name=long) for each in ambiguous.alternatives)
    assert title(replace(ambiguous, alternatives=far)).startswith(f"One of {len(far)} effects, not")
    sizes = {"piston_diameter": "40 mm", "rod_diameter": "25 mm", "stroke": "400 mm"}
    about = replace(
        named.provenance, stopped="2026-01-01T01:30:00", software={"hbench": "0.1.0"},
        settings={"specimen": {"serial": "HC-0007"}},
    )  # fmt: skip
    found = replace(named, provenance=about, revised=named.revised | {"test_cylinder": sizes})
    page = breakable(diagnosis_page(found, ()))
    facts = dict(re.findall(r"<div><dt>(.*?)</dt><dd>(.*?)</dd></div>", page))
    assert facts["Model"] == "model-aau.yaml" and facts["Cylinder"] == "HC-0007"
    assert facts["Dimensions"].replace("\N{NO-BREAK SPACE}", " ") == (
        "bore 40 mm, rod 25 mm, stroke 400 mm"
    )
    assert facts["Simulated time"].startswith("2026-01-01 00:00:00 to ")
    assert facts["Analysis"] == "hbench 0.1.0" and "Instruments" in facts

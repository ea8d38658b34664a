"""A campaign with a run of each kind on the virtual rig, analysed as a whole."""

import json

import pytest

from hbench import workflow
from hbench.analysis.by_kind import analyse_runs
from hbench.analysis.screening.screen import screen
from hbench.config.fitting import Fitting
from hbench.config.schedule import Screening
from hbench.config.setup import Setup
from hbench.report.campaign.terminal import summary_text
from tests.support.analysis.moving import moving_run, ramp_velocity

LOAD = {"p_lr": "15 bar", "loads": ["2000 N"], "hold": "0.2 s", "trials": 2}
TRAVEL = {"travel": {"start": "140 mm", "end": "240 mm"}}
EVERY_KIND = [
    {"kind": "ramp", "direction": "extend", "speed": "120 mm/s"}
    | {"accelerations": ["0.1 m/s^2", "0.2 m/s^2"]},
    {"kind": "triangle", "speed": "100 mm/s", "cycles": 2},
    {"kind": "steps", "levels": ["50 mm/s", "-50 mm/s"], "dwell": "0.6 s"},
    {"kind": "hold", "positions": ["200 mm"], "duration": "1.5 s"},
    {
        "kind": "verification",
        "profile": [{"velocity": "40 mm/s", "acceleration": "0.2 m/s^2", "duration": "1 s"}],
    },
]


def test_each_kind_gets_its_verdict_and_its_results_and_the_page_shows_them(rig_campaign):
    experiments = [
        (LOAD | own) if own["kind"] == "hold" else (LOAD | TRAVEL | own) for own in EVERY_KIND
    ]
    folder = rig_campaign(experiments, 1)
    results = workflow.report(folder)
    made = folder / "results"
    document = json.loads((made / "results.json").read_text())
    assert {run["kind"] for run in document["runs"]} == {own["kind"] for own in EVERY_KIND}
    assert all(run["accepted"] for run in document["runs"]), document["runs"]
    kinds = [(c["kind"], c["direction"], c["a_ref_m_s2"]) for c in document["curves"]]
    assert kinds == [
        ("ramp", "extend", 0.1),
        ("ramp", "extend", 0.2),
        ("steps", "extend", None),
        ("steps", "retract", None),
    ]
    for curve in document["curves"]:
        laws = [fit["law"] for fit in curve["fits"]]
        assert ("tustin" in laws) == (curve["kind"] == "ramp"), "steps are too few"
    assert len(document["comparisons"]) == 2 and len(document["loops"]) == 1
    assert document["loops"][0]["trials"] == 2 and document["loops"][0]["area_j"] > 0
    assert len(document["levels"]) == 2 and document["levels"][0]["n"] == 2
    (leak,) = document["leakage"]
    assert "across_piston" in leak["message"] and len(leak["decays"]) == 2
    text = summary_text(results)
    counts = {"ramp": 4, "triangle": 2, "steps": 2, "hold": 2, "verification": 2}
    assert all(f"{count} {kind}" in text for kind, count in counts.items())
    assert "few" not in text, "curves that are no steady ones are not missed for a fit"
    page = (made / "report.html").read_text()
    assert all(f'<h2 id="{n}">' in page for n in ("ramps", "hysteresis", "steps", "leakage"))


def test_without_a_bench_file_the_inertia_stays_in_and_leakage_is_left_out_and_both_are_told():
    v = ramp_velocity(0.1, 0.2)
    ramp = moving_run("ramp", v, 300.0, 40.0, plan={"a_ref_m_s2": 0.1})
    hold = moving_run("hold", 0 * v, 0.0)
    screened = tuple(screen(run, Screening()) for run in (ramp, hold))
    assert all(one.accepted for one in screened)
    analysed = analyse_runs(screened, Setup(None, None, None), Fitting())
    (curve,) = analysed.moving
    assert curve.points[9].friction_n == pytest.approx(300 + 40 * 0.1, abs=0.1)
    assert analysed.motions.leakages == ()
    assert all(any(word in note for note in analysed.notes) for word in ("mass", "leakage"))

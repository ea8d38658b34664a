"""Breakaway, as the virtual rig measures it, against the plant's own law."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from hbench import workflow
from hbench.config.bench import parse_plant
from hbench.errors import DataError
from hbench.model.build import plant_parameters
from hbench.model.friction.laws import steady_parts
from hbench.report.campaign.reasons import cause_of
from hbench.store.campaign.folder import load_campaign
from hbench.workflow.results import derive

CONFIGS = Path(__file__).parents[2] / "configs"
BENCH = yaml.safe_load((CONFIGS / "bench-aau.yaml").read_text())
RATE = 500.0
SEALS = {
    "piston_seal": "2 N/bar",
    "rod_seal": "0.4 N/bar",
    "scatter": "0 %",
    "viscous": "1800 N s/m",
}
DRY = {"coulomb": "210 N", "stiction": "620 N", "stribeck_velocity": "25 mm/s"}
PLANTS = {
    # Neither is the law of the fits, Tustin's with the exponent 1.
    "static, exponent 2": {"law": "tustin", **DRY, "stribeck_exponent": 2, **SEALS},
    "Maxwell-slip elements": {"law": "leuven", **DRY, "stribeck_exponent": 1.5, **SEALS,
                              "presliding": "0.4 mm", "shape": 2, "bristle_damping": "500 N s/m",
                              "elements": ["500 N", "400 N", "300 N"]},
}  # fmt: skip
BRISTLES = {
    **{"law": "lugre", **DRY, "stribeck_exponent": 0.7, **SEALS},
    **{"bristle_stiffness": "2e6 N/m", "bristle_damping": "2000 N s/m"},
}
VALVES = {"valve_trim": {"gain_test": "-4 %", "gain_load_1": "3 %", "null_test": "0.02 V"}}


def schedule(folder, **changes):
    push = {
        **{"kind": "breakaway", "direction": "extend", "p_lr": "15 bar", "loads": ["1500 N"]},
        **{"trials": 2, "position": "180 mm", "dwells": ["0.5 s"], "rate": f"{RATE} N/s"},
        **{"rise": "4000 N"},
    }
    back = {"direction": "retract", "p_lr": "110 bar", "loads": ["-1500 N"]}
    data = {"name": "breakaway", "bench": str(CONFIGS / "bench-aau.yaml")}
    experiments = [push | changes, push | changes | back]
    path = folder / "schedule.yaml"
    path.write_text(yaml.safe_dump(data | {"experiments": experiments}))
    return path


def plant_file(folder, **sections):
    path = folder / "plant.yaml"
    path.write_text(yaml.safe_dump(sections))
    return path


def static_friction_n(friction, measured):
    """Dry friction of the law as the piston comes to rest, at the pressures of the peak."""
    plant = parse_plant(BENCH, {"friction": {"test": friction}}, "plant")
    law = plant_parameters(plant).test.friction
    return steady_parts(1e-9, measured.p_tp_pa, measured.p_tr_pa, 1.0, law)[0]


@pytest.mark.parametrize("name", PLANTS)
def test_breakaway_of_plants_with_other_laws_is_within_one_per_cent(name, tmp_path, on_the_rig):
    """Converter noise; the bias counts, not the scatter, which is none here.

    Valves are unequal under the static law. Elements with effects would be another plant to
    compile; with none, and with three, it is that of the fits.
    """
    effects = VALVES if PLANTS[name]["law"] == "tustin" else {}
    plant = plant_file(tmp_path, friction={"test": PLANTS[name]}, effects=effects)
    campaign = on_the_rig(schedule(tmp_path), tmp_path / "campaign", plant=plant)
    results = derive(campaign)
    assert all(run.accepted for run in results.runs), [run.reasons for run in results.runs]
    for measured in results.motions.breakaways:
        true = static_friction_n(PLANTS[name], measured)
        print(f"{name}, {measured.direction}: {measured.breakaway_n:.1f} N, true {true:.1f} N")
        assert measured.breakaway_n == pytest.approx(true, rel=0.01, abs=5.0)
        assert measured.rate_n_s == RATE and measured.dwell_s == 0.5 and measured.n == 2
        at_rest = next(
            series for series in results.headline.series if series.direction == measured.direction
        )
        assert at_rest.breakaway_n.basis == "breakaway" and at_rest.breakaway_dwell_s == 0.5
        assert at_rest.breakaway_n.u95 == measured.u95_n > 40


def test_breakaway_of_two_cylinders_differs_by_that_of_their_laws(tmp_path, on_the_rig):
    """Another seed, less static friction; the instruments are the same and their errors cancel."""
    laws = [PLANTS["static, exponent 2"], PLANTS["static, exponent 2"] | {"stiction": "560 N"}]
    for seed, (name, law) in enumerate(zip("ab", laws, strict=True), start=1):
        (tmp_path / name).mkdir()
        plant = plant_file(tmp_path / name, friction={"test": law})
        file = schedule(tmp_path / name, trials=3)
        on_the_rig(file, tmp_path / name / "campaign", plant=plant, seed=seed)
    found = workflow.compare(tmp_path / "a" / "campaign", tmp_path / "b" / "campaign")
    assert [each.a.direction for each in found.breakaways] == ["extend", "retract"]
    for each in found.breakaways:
        measured = each.breakaway_n
        true = static_friction_n(laws[1], each.b) - static_friction_n(laws[0], each.a)
        print(f"{each.a.direction}: {measured.value:.1f} +- {measured.u95:.1f} N, true {true:.1f}")
        assert abs(measured.value - true) <= measured.u95 < 0.5 * measured.u95_a
        assert measured.real


def test_a_comparison_with_pushes_that_were_all_rejected_says_so(tmp_path, on_the_rig):
    """Friction that only rises with the speed has no maximum."""
    flat = PLANTS["static, exponent 2"] | {"stiction": "210 N"}
    for name, law in zip("ab", (PLANTS["static, exponent 2"], flat), strict=True):
        (tmp_path / name).mkdir()
        plant = plant_file(tmp_path / name, friction={"test": law})
        on_the_rig(schedule(tmp_path / name, trials=1), tmp_path / name / "campaign", plant=plant)
    b = tmp_path / "b" / "campaign"
    with pytest.raises(DataError, match="have nothing in common") as caught:
        workflow.compare(tmp_path / "a" / "campaign", b)
    assert f"\n{b}: 2 of 2 runs were rejected (incomplete)" in str(caught.value)
    assert "`hbench report` states what to look for" in caught.value.hint
    assert "larger displacement" in cause_of(derive(load_campaign(b)), "incomplete")


def test_the_largest_friction_of_creeping_bristles_is_that_of_a_finer_log(tmp_path, on_the_rig):
    """The same seed makes the same motion; 250 Hz is the most that the board's log can hold.

    Creep makes them break away well below their static friction, by an amount that no formula gives
    for this law.
    """
    found = {}
    for rate in (100, 250):
        bench = BENCH | {"controllers": BENCH["controllers"] | {"log_rate": f"{rate} Hz"}}
        (tmp_path / f"{rate}.yaml").write_text(yaml.safe_dump(bench))
        file = schedule(tmp_path, trials=1)
        file.write_text(
            yaml.safe_dump(yaml.safe_load(file.read_text()) | {"bench": f"{rate}.yaml"})
        )
        plant = plant_file(tmp_path, friction={"test": BRISTLES}, effects=VALVES)
        found[rate] = derive(on_the_rig(file, tmp_path / f"c{rate}", plant=plant))
    fine = [run.run for run in found[250].runs]
    for measured, run in zip(found[100].motions.breakaways, fine, strict=True):
        specimen = run.plan.specimen
        f_test = run.p_tp_pa * specimen.area_piston_m2 - run.p_tr_pa * specimen.area_rod_m2
        moved = np.abs(run.x_m - run.x_m[0])
        before = slice(np.argmax(moved > measured.displacement_m + 3e-4))
        largest = np.abs(f_test - run.f_applied_n)[before].max()
        print(f"{measured.breakaway_n:.1f} N, largest of the finer log {largest:.1f} N")
        assert measured.breakaway_n == pytest.approx(largest, rel=0.01, abs=5.0)

"""Holds of a leakage stand that logs trapped oil: its leaks against those that made the logs."""

import math
import re
from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, solve_ivp

from hbench.analysis.conformity.acceptance import conformity_checks
from hbench.config.conformity.limits import parse_limits
from hbench.records import HeadlineSeries
from hbench.report.campaign.page import report_document
from hbench.report.campaign.page_tables import cause_table
from hbench.report.campaign.sections.method import method_section
from hbench.report.headline import headline_tiles
from hbench.store.campaign.folder import load_campaign
from hbench.workflow.results import derive
from tests.support.commands import hbench

BETA, DEAD = 1.2e9, 50e-6  # [Pa], [m^3] on either side
A_P, A_R, STROKE = math.pi / 4 * 0.063**2, math.pi / 4 * (0.063**2 - 0.036**2), 0.4
ML_MIN = 1e-6 / 60
ACROSS, ROD_OUT = 5 * ML_MIN / 1e7, 0.5 * ML_MIN / 1e7  # [m^3/(s Pa)]: at 100 bar 5, 0.5 ml/min
STARTS_BAR = ((150, 20), (100, 20), (60, 100), (150, 60), (80, 150))
MAP = """\
name: leak stand
kind: hold
columns:
  t_s: {{column: t, unit: s}}
  x_m: {{column: x, unit: mm}}
  p_tp_pa: {{column: pA, unit: bar}}
  {rod_side}
series:
  - label: seals
    files: hold_{{trial}}.csv
    cylinder: {{piston_diameter: 63 mm, rod_diameter: 36 mm{stroke}}}
{more}"""
CHAMBERS = (
    "chambers: {bulk_modulus: 12000 bar, dead_volume_piston: 50 cm^3, dead_volume_rod: 50 cm^3}\n"
)
SLOW, CREEPS = "screening: {max_gap: 0.3 s}\n", "screening: {max_gap: 0.3 s, rest_travel: 20 mm}\n"
LOGGED, OPEN = "p_tr_pa: {column: pB, unit: bar}", ""
PORT = "temp_port_k: {column: T, unit: degC}"
EXPANSION_1_K = 7.2e-4  # of mineral oil


def decay(start_bar, *, locked, is_open=False):
    """Solve oil that leaks from closed chambers, the rod clamped or carrying a weight."""

    def rates(t, y):
        p, r, x = y
        across, out = ACROSS * (p - r), ROD_OUT * r
        v_p, v_r = DEAD + A_P * x, DEAD + A_R * (STROKE - x)
        c_p, c_r = BETA / v_p, BETA / v_r
        v = 0.0 if locked else (A_R * c_r * (out - across) - A_P * c_p * across)
        v = v / (A_P**2 * c_p + A_R**2 * c_r)  # A_P dp/dt = A_R dr/dt
        rate_r = 0.0 if is_open else c_r * (across - out + A_R * v)
        return [c_p * (-across - A_P * v), rate_r, v]

    t = np.arange(0, 120, 0.2)
    start = [1e5 * start_bar[0], 0.0 if is_open else 1e5 * start_bar[1], 0.2]
    return t, solve_ivp(rates, (0, 120), start, t_eval=t, rtol=1e-9, atol=[1, 1, 1e-12]).y


def campaign(
    folder,
    *,
    more=CHAMBERS + SLOW,
    stroke=", stroke: 400 mm",
    locked=True,
    is_open=False,
    warming_k_min=0.0,
    port=None,
):
    """Write and import the holds; ``port`` returns the logged temperature [degC] of the oil's."""
    rng = np.random.default_rng(4)
    (folder / "logs").mkdir()
    for number, start in enumerate(STARTS_BAR, start=1):
        t, (p, r, x) = decay(start, locked=locked, is_open=is_open)
        noise = rng.normal(0, (0.02, 0.02, 0.002), (len(t), 3)).T
        degc = 45 + warming_k_min * t / 60
        p, r = (pressure + BETA * EXPANSION_1_K * (degc - 45) for pressure in (p, r))
        columns = [t, 1e3 * x + noise[2], p / 1e5 + noise[0], r / 1e5 + noise[1], degc]
        columns[4] = degc if port is None else port(degc)
        path = folder / "logs" / f"hold_{number}.csv"
        np.savetxt(path, np.column_stack(columns), "%.3f", ",", header="t,x,pA,pB,T", comments="")
    channels = [OPEN if is_open else LOGGED, *[PORT] * (port is not None)]
    text = MAP.format(rod_side="\n  ".join(channels), stroke=stroke, more=more)
    if is_open:
        text += "constants: {p_tr_pa: 0 bar}\n"
    (folder / "map.yaml").write_text(text)
    words = "import", folder / "logs", "--map", folder / "map.yaml", "-o", folder / "campaign"
    assert hbench(*words).returncode == 0
    return derive(load_campaign(folder / "campaign"))


LEAKS = ("across_piston", "rod_side_out", "piston_side_out")


def folders(path):
    for name in ("a", "b"):
        (path / name).mkdir()
        yield path / name


def flow_ml_min(results, leak, pressure_bar):
    (leakage,) = results.motions.leakages
    (one,) = (each for each in leakage.coefficients if each.name == leak)
    flow, half = leakage.flow_m3_s(one, 1e5 * pressure_bar)
    return flow / ML_MIN, half / ML_MIN


@pytest.mark.parametrize("locked", [True, False], ids=["locked", "creeping"])
def test_the_leaks_of_imported_holds_are_those_that_made_the_logs(tmp_path, locked):
    results = campaign(tmp_path, more=CHAMBERS + CREEPS, locked=locked)
    for leak, truth in (("across_piston", 5.0), ("rod_side_out", 0.5), ("piston_side_out", 0.0)):
        flow, half = flow_ml_min(results, leak, 100)
        assert flow == pytest.approx(truth, abs=0.02) and abs(flow - truth) < half


@pytest.mark.parametrize("warming_k_min", [-0.8, 0.6])
def test_an_oil_that_was_measured_to_cool_or_warm_widens_u(tmp_path, warming_k_min):
    """Without the temperature U assumes 0.2 K/min, and 2 of the 3 leaks are outside."""
    found = campaign(tmp_path, warming_k_min=warming_k_min, port=lambda degc: degc)
    for leak, truth in (("across_piston", 5.0), ("rod_side_out", 0.5), ("piston_side_out", 0.0)):
        flow, half = flow_ml_min(found, leak, 100)
        assert abs(flow - truth) < half
    (leakage,) = found.motions.leakages
    words = f"a change of the oil temperature at {abs(warming_k_min):g} K/min, the largest measured"
    assert words in leakage.message


@pytest.mark.parametrize(
    "port",
    [
        lambda degc: degc + np.random.default_rng(1).normal(0, 1.0, len(degc)),
        lambda degc: np.where(np.arange(len(degc)) < len(degc) / 2, 45.0, 46.0),
    ],
    ids=["noise", "one step of a coarse sensor"],
)
def test_noise_and_steps_of_a_temperature_are_no_warming(tmp_path, port):
    found, usual = (
        campaign(folder, port=each)
        for folder, each in zip(folders(tmp_path), (port, None), strict=True)
    )
    assert [flow_ml_min(found, name, 100) for name in LEAKS] == [
        flow_ml_min(usual, name, 100) for name in LEAKS
    ]


def test_a_limit_in_litres_per_minute_is_decided_by_imported_holds(tmp_path):
    results = campaign(tmp_path)
    limit = {"quantity": "leakage", "leak": "rod_side_out", "pressure": "100 bar"}
    limits = [limit | {"max": "0.001 l/min"}, limit | {"max": "0.0003 l/min"}]
    requirements = [each.requirement for each in parse_limits({"limits": limits}, "").limits]
    checks = conformity_checks(results, requirements, "guard_band", None)
    assert [check.decision for check in checks] == ["PASS", "FAIL"]


def test_a_page_of_holds_begins_with_the_largest_leak(tmp_path):
    """5 ml/min at 100 bar are 6 ml/min at the highest difference, 121 bar."""
    results = campaign(tmp_path, more=CHAMBERS + CREEPS, locked=False)
    document = report_document(results, ())
    assert re.match(
        r"The largest leakage is 6\.\d\d ± 0\.\d\d ml/min, across the piston at 121 bar\. ",
        document.verdict,
    )
    assert "Leakage of a cylinder" in document.subtitle
    titles = [section.title for section in document.sections]
    assert "Friction" not in titles
    tile = document.sections[0].tiles[0]
    assert tile.unit == "ml/min" and float(tile.value.split()[0]) == pytest.approx(6.05, abs=0.05)
    tight = replace(results.motions, leakages=(_tight(results.motions.leakages[0]),))
    (first, *_) = headline_tiles(replace(results, motions=tight))
    assert "the interval contains 0" in first.more


def test_a_leak_that_is_not_significant_is_no_headline_beside_friction(tmp_path):
    results = campaign(tmp_path)
    no_numbers = dict.fromkeys(field.name for field in fields(HeadlineSeries))
    series = HeadlineSeries(**no_numbers | {"kind": "steady", "direction": "extend"})
    beside = replace(results, headline=replace(results.headline, series=(series,)))
    assert "ml/min" in [tile.unit for tile in headline_tiles(beside)]
    tight = replace(results.motions, leakages=(_tight(results.motions.leakages[0]),))
    assert "ml/min" not in [tile.unit for tile in headline_tiles(replace(beside, motions=tight))]


def test_a_leak_that_flows_backwards_is_not_said_to_contain_0(tmp_path):
    """As by a transducer that drifts."""
    results = campaign(tmp_path)
    (leakage,) = results.motions.leakages
    back = replace(results.motions, leakages=(_tight(leakage, value=-1e-12, half=1e-13),))
    (first, *_) = headline_tiles(replace(results, motions=back))
    assert first.value.startswith("−") and "contains 0" not in first.more


def _tight(leakage, value=0.0, half=1e-13):
    """The same holds with other leaks [m^3/(s Pa)]; by default with intervals that contain 0."""
    ci95 = value - half, value + half
    coefficients = (replace(one, value=value, ci95=ci95) for one in leakage.coefficients)
    return replace(leakage, coefficients=tuple(coefficients))


def test_methods_of_instruments_that_nobody_stated_are_not_listed(tmp_path):
    facts = dict(method_section(campaign(tmp_path)).facts)
    assert "Leakage" in facts and "Instruments" not in facts


def test_without_volumes_or_stroke_the_note_names_the_key_of_the_map(tmp_path):
    for name, given in (("chambers", {"more": SLOW}), ("stroke", {"stroke": ""})):
        (tmp_path / name).mkdir()
        results = campaign(tmp_path / name, **given)
        assert not results.motions.leakages
        assert any(f"add '{name}' to" in note for note in results.notes)


def test_a_side_open_to_the_air_is_not_balanced(tmp_path):
    """The oil that leaks across the piston leaves by the open port."""
    results = campaign(tmp_path, is_open=True)
    (leakage,) = results.motions.leakages
    assert all(one.value is None for one in leakage.coefficients)
    for hold, start in zip(leakage.decays, STARTS_BAR, strict=True):
        t, (p, *_) = decay(start, locked=True, is_open=True)
        slope, _ = np.polyfit(t, ACROSS * cumulative_trapezoid(p, t, initial=0), 1)
        assert hold.out_p_m3_s == pytest.approx(slope, rel=0.01)
        assert hold.out_r_m3_s == 0.0


def test_holds_rejected_for_creep_are_not_blamed_on_the_controller(tmp_path):
    results = campaign(tmp_path, locked=False)
    (row,) = cause_table(results).rows
    assert row[0].text == "Off reference" and row[1].text == "5"
    assert "screening.rest_travel" in row[2].text and "controller" not in row[2].text


def test_campaigns_without_friction_are_not_compared(tmp_path):
    for name in "ab":
        (tmp_path / name).mkdir()
        campaign(tmp_path / name, more=CHAMBERS + SLOW if name == "a" else SLOW)
    done = hbench("compare", tmp_path / "a" / "campaign", tmp_path / "b" / "campaign")
    assert done.returncode == 4 and "have neither curves nor breakaway to compare" in done.stderr
    assert "For leakage" in done.stderr

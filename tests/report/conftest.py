"""Made-up results: the numbers have the shape of a campaign's, and were measured by nobody."""

import json
import math
from dataclasses import replace
from datetime import date
from importlib.resources import files

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from hbench.analysis.conformity.acceptance import conformity_checks
from hbench.analysis.conformity.certified import certified_trials, certified_values
from hbench.analysis.curves.band_trends import band_trends
from hbench.config.conformity.certificate import completed, parse_certificate
from hbench.records import (
    Band,
    Curve,
    CurvePoint,
    EfficiencyCurve,
    EfficiencyPoint,
    Fit,
    FitParameter,
    MeanEfficiency,
    Provenance,
    Run,
    RunPlan,
    ScreenedRun,
    Specimen,
    SteadyMeans,
)
from hbench.records.conformity.acceptance import Requirement
from hbench.report.campaign.figures.all_figures import draw_all
from hbench.report.conformity.certificate.certificate import Certificate
from hbench.store.campaign.folder import load_campaign
from hbench.store.campaign.raw_logs import raw_data
from hbench.workflow.conformity.acceptance import decided
from hbench.workflow.results import derive
from tests.support import ROOT
from tests.support.certificates import FILE, LIMITS
from tests.support.report import summarised
from tests.support.report.made_page import made_results
from tests.support.shared import once

SPECIMEN = Specimen(area_piston_m2=1.25664e-3, area_rod_m2=7.65763e-4, stroke_m=0.4)
T95_2DOF = 4.302653


def tustin(v, coulomb, stiction, stribeck, viscous):
    return (
        np.sign(v) * (coulomb + (stiction - coulomb) * np.exp(-np.abs(v) / stribeck)) + viscous * v
    )


def parameter(value, unit, half=None, at_bound=None):
    if half is None:
        return FitParameter(value, None, None, at_bound, unit)
    return FitParameter(value, half / 2, (value - half, value + half), at_bound, unit)


def steady_run(name, v, load, trial, friction, reasons=(), label="", kind="steady", p_tp=5e6):
    plan = RunPlan(
        name, kind, trial, v, SPECIMEN, a_ref_m_s2=1.0, f_load_n=load, p_lr_ref_pa=15e5, label=label
    )
    run = Run(plan, t_s=np.arange(3) / 100, x_m=np.arange(3) * v / 100)
    applied = load or 0.0
    means = SteadyMeans(0.8, 2.3, 150, v, friction, applied + friction, applied, p_tp, 8e5, 0.8)
    return ScreenedRun(run, tuple(reasons), None if "truncated" in " ".join(reasons) else means)


def point(v, trials, runs, load, p_tp=5e6, p_tr=8e5):
    mean, n = float(np.mean(trials)), len(trials)
    ci = T95_2DOF * float(np.std(trials, ddof=1)) / math.sqrt(n) if n > 1 else None
    f_test = load + mean
    tests = tuple(load + f for f in trials)
    return CurvePoint(
        v_m_s=v,
        friction_n=mean,
        ci95_n=ci,
        n=n,
        f_test_n=f_test,
        f_applied_n=load,
        p_tp_pa=p_tp,
        p_tr_pa=p_tr,
        trials=tuple(range(1, n + 1)),
        trials_n=tuple(trials),
        trials_f_test_n=tests,
        runs=tuple(runs),
    )


def band(label, load, extend, retract, half_ci95_n):
    both = list(zip(extend.trials_n, retract.trials_n, strict=True))
    interval = half_ci95_n is not None
    return Band(
        kind="steady",
        label=label,
        specimen=SPECIMEN,
        f_load_n=load,
        p_lr_ref_pa=15e5,
        v_m_s=extend.v_m_s,
        p_tp_pa=(extend.p_tp_pa + retract.p_tp_pa) / 2,
        half_n=(extend.friction_n - retract.friction_n) / 2,
        half_ci95_n=half_ci95_n,
        middle_n=(extend.friction_n + retract.friction_n) / 2,
        middle_ci95_n=2 * half_ci95_n if interval else None,
        energy_j=0.08 * extend.friction_n if interval else None,
        energy_ci95_j=0.08 * half_ci95_n if interval else None,
        n=extend.n,
        trials=extend.trials,
        trials_half_n=tuple((a - b) / 2 for a, b in both),
        trials_middle_n=tuple((a + b) / 2 for a, b in both),
        trials_energy_j=tuple(0.08 * a for a, _ in both) if interval else (),
        extend=extend,
        retract=retract,
    )


REJECTIONS = (
    "off_reference: mean speed 187.3 mm/s, 12.7 mm/s from the reference; limit 2 mm/s",
    "end_stop: within 2 mm of the end-stop inside the window",
    "never_steady: friction drifts by 96 N over the window; limit 52 N",
    "truncated: 412 of 1000 records",
    "sensor_saturated: p_tp at 4095 counts for 31 samples",
    "valve_saturated: u_t at 10 V for 44 samples",
)


def stribeck_results(loads=(500.0, 1000.0, 2000.0, 5000.0), speeds=15, source="simulated"):
    """Both directions, three trials; a bad run here and there; one fit on its bound."""
    rng = np.random.default_rng(7)
    v_all = np.linspace(0.005, 0.2, speeds) ** 1.4 / 0.2**0.4
    runs, curves, efficiency = [], [], []
    for direction, sign in (("extend", 1), ("retract", -1)):
        for rank, size in enumerate(loads):
            load = sign * size
            true = (300 + 0.02 * size + 25 * sign, 480 + 0.03 * size, 0.05, 1300.0)
            points, etas = [], []
            for i, v in enumerate(sign * v_all):
                trials = tustin(v, *true) + rng.normal(0, 6, 3)
                names = [f"{direction}-{rank}-{i:02d}-{trial}" for trial in (1, 2, 3)]
                bad = len(runs) % 42 == 39
                for trial, (name, friction) in enumerate(zip(names, trials, strict=True)):
                    reasons = (REJECTIONS[len(runs) // 42 % 6],) if bad and trial == 2 else ()
                    runs.append(steady_run(name, v, load, trial + 1, float(friction), reasons))
                keep = 2 if bad else 3
                points.append(point(v, trials[:keep], names[:keep], load))
                eta = load / points[-1].f_test_n
                sigma = 0.013 * eta + 0.004
                both = np.hypot(sigma, 0.006)
                ci95 = 4.303 * 0.006
                u95 = np.hypot(1.959964 * sigma, ci95)
                etas.append(EfficiencyPoint(v, eta, sigma, 0.006, "", both, ci95, u95))
            at_bound = rank == 0 and sign == 1
            grid = np.union1d(np.linspace(v_all[0], v_all[-1], 100), v_all) * sign
            fit = Fit(
                "tustin",
                {
                    "f_coulomb_n": parameter(0.0, "N", None, "lower")
                    if at_bound
                    else parameter(true[0], "N", 23.4),
                    "f_stiction_n": parameter(true[1], "N", 12.3),
                    "v_stribeck_m_s": parameter(0.05, "m/s", 0.0071),
                    "b_viscous_n_s_m": parameter(1300.0, "N s/m", 145.0),
                },
                6.2,
                True,
                "F_C sits at its lower bound: the data does not determine it." if at_bound else "",
                tuple((float(v), float(f)) for v, f in zip(grid, tustin(grid, *true), strict=True)),
            )
            curves.append(
                Curve("steady", direction, load, 15e5, "", SPECIMEN, tuple(points), (fit,))
            )
            mean = MeanEfficiency(
                0.8,
                0.02,
                0.002,
                0.0201,
                {"load cell": 0.01, "piston-side pressure": -0.015, "rod-side pressure": 0.005},
                len(etas),
            )
            efficiency.append(
                EfficiencyCurve("steady", direction, load, 15e5, "", tuple(etas), mean)
            )
    provenance = Provenance(
        "Stribeck curves, steady state",
        source,
        "AAU cylinder friction bench (reconstructed)",
        "hbench-core 0.1.0 host 3f9a1c2e",
        "2025-03-01T09:12:00+01:00",
        "2025-03-01T10:40:12+01:00",
        {"hbench": "0.1.0", "python": "3.12.3"},
        {"port": "sim", "seed": 1, "plant_sha256": "9b1f" * 16},
    )
    notes = ("Curve retract 5000 N: one point has two trials.",)
    return made_results(provenance, tuple(runs), tuple(curves), tuple(efficiency), (), notes)


def seal_results():
    """Two seals, four pressures, both directions, one speed; three trials and one trial."""
    rng = np.random.default_rng(3)
    runs, curves, bands = [], [], []
    area = math.pi / 4 * 0.025**2
    seals = {"O-ring": ((4.0, 5.6, 7.2, 8.0), 3, 0.36), "NAPN": ((3.3, 6.9, 9.8, 11.9), 1, 0.51)}
    for label, (halves, trials, offset) in seals.items():
        for bar, half in zip((1, 3, 5, 7), halves, strict=True):
            load = bar * 1e5 * area
            sides = []
            for direction, sign in (("extend", 1), ("retract", -1)):
                frictions = sign * half + offset * bar + rng.normal(0, 0.3, trials)
                names = [f"{label}-{bar}bar-{direction}-{k}" for k in range(trials)]
                runs += [
                    steady_run(name, sign * 0.02, load, k + 1, float(f), (), label, p_tp=bar * 1e5)
                    for k, (name, f) in enumerate(zip(names, frictions, strict=True))
                ]
                one = point(sign * 0.02, frictions, names, load, bar * 1e5, None)
                curves.append(Curve("steady", direction, load, 15e5, label, SPECIMEN, (one,)))
                sides.append(one)
            bands.append(band(label, load, *sides, 0.1 * bar if trials > 1 else None))
    provenance = Provenance(
        "Seals of a printed cylinder", "imported", "unknown", "", "", "", {"hbench": "0.1.0"}, {}
    )
    return made_results(
        provenance,
        tuple(runs),
        tuple(curves),
        (),
        tuple(bands),
        ("No efficiency: no load cell.",),
        band_trends=band_trends(bands),
    )


@pytest.fixture(scope="session")
def schema_faults():
    """Return a function that tells where a document is not all that its schema tells of."""
    validators = {}
    for room, name in (("campaign", "results"), ("diagnosis", "diagnosis")):
        file = files(f"hbench.report.{room}") / f"{name}.schema.json"
        schema = json.loads(file.read_text())
        Draft202012Validator.check_schema(schema)
        validators[name] = Draft202012Validator(_closed(schema))
    return lambda document, name="results": [
        f"{error.json_path}: {error.message[:200]}"
        for error in validators[name].iter_errors(document)
    ]


def _closed(schema):
    """Return the schema with no keys but those that it tells of."""
    if isinstance(schema, list):
        return [_closed(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    told = {key: _closed(value) for key, value in schema.items()}
    own = "properties" in schema and isinstance(schema.get("type"), str)
    return told | {"additionalProperties": False} if own else told


@pytest.fixture(scope="session")
def stribeck():
    return stribeck_results()


@pytest.fixture(scope="session")
def small():
    return stribeck_results(loads=(500.0, 5000.0), speeds=5)


@pytest.fixture(scope="session")
def drawings(small):
    return once("drawings-small-png", lambda: draw_all(small, png=True))


@pytest.fixture(scope="session")
def two_rod_sides(small):
    """The small campaign, once more at another rod-side pressure of the load cylinder."""

    def again(run):
        plan = replace(run.run.plan, p_lr_ref_pa=60e5)
        return replace(run, run=replace(run.run, plan=plan))

    return replace(
        small,
        runs=small.runs + tuple(map(again, small.runs)),
        curves=small.curves + tuple(replace(c, p_lr_ref_pa=60e5) for c in small.curves),
        efficiency=small.efficiency + tuple(replace(c, p_lr_ref_pa=60e5) for c in small.efficiency),
    )


@pytest.fixture(scope="session")
def seals():
    return seal_results()


@pytest.fixture(scope="module")
def sample_campaign():
    return load_campaign(ROOT / "data_samples" / "stribeck-small")


@pytest.fixture(scope="module")
def sample_results(sample_campaign):
    return derive(sample_campaign)


@pytest.fixture(scope="module")
def certificate(sample_campaign, sample_results, tmp_path_factory):
    """Return a function that makes a certificate; keywords replace keys of its file."""
    limits = tmp_path_factory.mktemp("limits") / "limits.yaml"
    limits.write_text(LIMITS)
    values, all_speeds = certified_values(sample_results, sample_campaign.setup().instruments)

    def make(source: str = "real", **keys) -> Certificate:
        file = parse_certificate(FILE | keys, "certificate.yaml")
        specimen, test = completed(file, {}, "certificate.yaml")
        provenance = replace(sample_results.provenance, source=source)
        return Certificate(
            file=file,
            issued=file.issued or date(2026, 2, 3),
            specimen=specimen,
            test=test,
            results=replace(sample_results, provenance=provenance),
            values=values,
            all_speeds=all_speeds,
            instruments=sample_campaign.setup().instruments,
            raw=raw_data(sample_campaign),
            acceptance=decided(sample_results, limits),
        )

    return make


@pytest.fixture
def many_decisions(certificate, sample_campaign, sample_results):
    """Return a function that makes a simulated certificate of 17 decisions."""
    limits = [
        *(Requirement("friction", "N", None, 2e3, v_m_s=v) for v in (0.0082, 0.085)),
        *(Requirement("speed_ripple", "%", None, 0.5, v_m_s=v) for v in (0.0082, 0.085)),
        Requirement("drift", "%", -0.2, 0.2),
    ]
    checks = conformity_checks(sample_results, limits, "guard_band", None)
    decided = [check.measurement for check in checks if check.measurement]
    values, _ = certified_values(sample_results, sample_campaign.setup().instruments, decided)
    values = (*values, *certified_trials(checks))

    def make(**keys) -> Certificate:
        made = certificate("simulated", **keys)
        return replace(made, values=values, acceptance=replace(made.acceptance, checks=checks))

    return make


@pytest.fixture
def few():
    """A diagnosis of too few runs."""
    return summarised.few()


@pytest.fixture
def compared():
    """A diagnosis with gaps, candidates and a working point, and nothing named."""
    return summarised.compared()


@pytest.fixture
def named():
    """A diagnosis with a leak."""
    return summarised.named()

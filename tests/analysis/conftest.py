"""Runs made here from closed forms, and runs of the virtual rig on a plant of the test's choice."""

import copy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from hbench import workflow
from hbench.analysis.screening.calibrate import calibrate
from hbench.config.bench import parse_bench
from hbench.config.files.loading import read_yaml
from hbench.config.schedule import Screening
from hbench.records import Curve, CurvePoint, Run, RunPlan, Specimen
from hbench.store.campaign.folder import load_campaign
from tests.support.analysis.other_plant import OTHER_PLANT
from tests.support.rig_campaign import measure_on_rig

SPECIMEN = Specimen(area_piston_m2=1.25e-3, area_rod_m2=0.75e-3, stroke_m=0.4)
RATE_HZ = 100.0
RAMP_S = 0.1


@pytest.fixture(scope="session")
def bench():
    path = Path(__file__).parents[2] / "configs" / "bench-aau.yaml"
    return parse_bench(read_yaml(path), str(path))


@pytest.fixture
def rig_campaign(tmp_path):
    """Return a function that makes ``experiments`` on the virtual rig and returns the folder.

    The board has the shipped bench file; the plant is another, ``friction`` replacing its test
    cylinder's. ``exact`` takes away the sensors' noise and the load cylinder's scatter.
    """

    def measure(experiments, seed, friction=None, exact=False) -> Path:
        folder = tmp_path / f"campaign-{len(list(tmp_path.glob('campaign-*')))}"
        plant = copy.deepcopy(OTHER_PLANT)
        if friction:
            plant["friction"]["test"] = friction
        if exact:
            plant["friction"]["load"]["scatter"] = 0.0
            plant["sensors"] = {"adc": {"noisy": False, "quantised": False}}
        shipped = Path(__file__).parents[2] / "configs" / "bench-aau.yaml"
        (tmp_path / "bench.yaml").write_text(shipped.read_text())
        (tmp_path / "plant.yaml").write_text(yaml.safe_dump(plant))
        schedule = {"name": "test", "bench": "bench.yaml", "experiments": experiments}
        (tmp_path / "schedule.yaml").write_text(yaml.safe_dump(schedule))
        measure_on_rig(
            workflow.load_experiment(tmp_path / "schedule.yaml", None),
            folder,
            plant=tmp_path / "plant.yaml",
            seed=seed,
        )
        return folder

    return measure


@pytest.fixture
def rig_runs(rig_campaign):
    """Return a function that makes ``experiments`` on the virtual rig; it returns runs in SI."""

    def measure(*arguments, **options) -> list[Run]:
        campaign = load_campaign(rig_campaign(*arguments, **options))
        return [calibrate(raw, campaign.bench()) for raw in campaign.raw_runs()]

    return measure


@pytest.fixture
def rules():
    return Screening(settle_travel="10 mm")


@pytest.fixture
def make_run():
    """Return a function that makes a run at a reference, with exact or noisy channels.

    ``v_m_s`` is the speed, ``v_ref_m_s`` the reference (the same where not given); ``wobble``
    and ``drift_n`` are functions of time added to speed [m/s] and friction [N].
    """

    def make(
        v_m_s=0.05,
        v_ref_m_s=None,
        friction_n=400.0,
        f_applied_n=2000.0,
        p_tr_pa=20e5,
        duration_s=2.0,
        wobble=None,
        drift_n=None,
        noise=0.0,
        seed=0,
        trial=1,
        **changes,
    ) -> Run:
        rng = np.random.default_rng(seed)
        t = (np.arange(round(duration_s * RATE_HZ)) + 0.5) / RATE_HZ
        fine = np.linspace(0, duration_s, 20 * len(t) + 1)
        v = v_m_s * np.minimum(fine / RAMP_S, 1) + (0 if wobble is None else wobble(fine))
        way = np.concatenate(([0], np.cumsum((v[1:] + v[:-1]) / 2 * np.diff(fine))))
        start = 0.02 if v_m_s > 0 else 0.38
        friction = np.sign(v_m_s) * friction_n + (0 if drift_n is None else drift_n(t))
        f_applied = np.full(len(t), f_applied_n) + noise * 20 * rng.standard_normal(len(t))
        p_tr = np.full(len(t), p_tr_pa) + noise * 5e3 * rng.standard_normal(len(t))
        p_tp = (f_applied_n + friction + p_tr_pa * SPECIMEN.area_rod_m2) / SPECIMEN.area_piston_m2
        run = Run(
            plan=RunPlan(
                run="0001",
                kind="steady",
                trial=trial,
                v_ref_m_s=v_m_s if v_ref_m_s is None else v_ref_m_s,
                specimen=SPECIMEN,
                f_load_n=f_applied_n,
            ),
            t_s=t,
            x_m=start + np.interp(t, fine, way) + noise * 2e-5 * rng.standard_normal(len(t)),
            p_tp_pa=p_tp + noise * 5e3 * rng.standard_normal(len(t)),
            p_tr_pa=p_tr,
            f_applied_n=f_applied,
            at_reference=t > RAMP_S,
            sensor_saturated=np.zeros(len(t), dtype=bool),
            valve_saturated=np.zeros(len(t), dtype=bool),
        )
        return replace(run, **changes)

    return make


@pytest.fixture
def make_curve():
    """Return a function that makes a curve from speeds and magnitudes of friction."""

    def make(v_m_s, friction_n, direction="extend", f_applied_n=2000.0) -> Curve:
        sign = 1.0 if direction == "extend" else -1.0
        points = tuple(
            CurvePoint(
                v_m_s=sign * float(v),
                friction_n=sign * float(f),
                ci95_n=None,
                n=1,
                f_test_n=f_applied_n + sign * float(f),
                f_applied_n=f_applied_n,
                p_tp_pa=(f_applied_n + sign * float(f) + 20e5 * SPECIMEN.area_rod_m2)
                / SPECIMEN.area_piston_m2,
                p_tr_pa=20e5,
                trials=(1,),
                trials_n=(sign * float(f),),
                trials_f_test_n=(f_applied_n + sign * float(f),),
                runs=("0001",),
            )
            for v, f in zip(v_m_s, friction_n, strict=True)
        )
        return Curve("steady", direction, f_applied_n, None, "", SPECIMEN, points)

    return make


@pytest.fixture
def trials_curve(make_curve):
    """Return a function that makes a curve of points with trials [N] (n, k), numbered alike."""

    def make(speeds, trials):
        curve = make_curve(speeds, trials.mean(axis=1))
        points = [
            replace(point, trials_n=tuple(own), trials=tuple(range(1, len(own) + 1)), n=len(own))
            for point, own in zip(curve.points, trials.tolist(), strict=True)
        ]
        return replace(curve, points=tuple(points))

    return make

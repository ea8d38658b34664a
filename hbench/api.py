"""Python API: a campaign as data frames, a friction law fitted to points, simulation of a bench.

``import hbench`` does not import this module; the first use of a function does.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from hbench.analysis.fitting.fit import CURVE_LAWS, fit_law
from hbench.analysis.fitting.prediction import predict_friction
from hbench.config.bench import parse_bench
from hbench.config.files.examples import example_path
from hbench.config.files.loading import read_yaml
from hbench.config.fitting import Fitting, parse_fitting
from hbench.errors import ConfigError, DataError
from hbench.model.build import plant_parameters
from hbench.model.plant import P_LP, P_LR, P_TP, P_TR, V, X, initial_state
from hbench.model.simulation import simulate as trajectory
from hbench.records import SERIES_FIELDS, SIGNS, Curve, CurvePoint, Direction, Fit, Specimen
from hbench.report.campaign.results_document import results_json
from hbench.store.campaign.folder import load_campaign
from hbench.store.exporting.runs import channels
from hbench.workflow.results import derive, screened_runs

_HEADLINE = ("friction_n", "breakaway_n", "efficiency")
_HEADLINE_COLUMNS = {"": "value", "_u95": "u95", "_ci95": "ci95", "_se": "se", "_basis": "basis"}
_FIT = ("law", "rmse_n", "converged", "verdict", "message")
_STATE = {"x_m": X, "v_m_s": V, "p_tp_pa": P_TP, "p_tr_pa": P_TR, "p_lp_pa": P_LP, "p_lr_pa": P_LR}
_START_PA = 15e5  # in the load chambers at the start of a simulation
_FASTEST_M_S = 10.0  # also the limit of a bench's speeds
_UNKNOWN = Specimen(float("nan"), float("nan"))


class Campaign:
    """A campaign, screened, averaged and fitted; nothing is written.

    ``results`` has the content of ``results.json``; the data frames are sections of it.
    """

    def __init__(self, folder: Path, how: Fitting):
        self._campaign = load_campaign(folder)
        self.results: dict[str, Any] = json.loads(results_json(derive(self._campaign, how)))

    @property
    def runs(self) -> pd.DataFrame:
        """One row per run, including rejected ones."""
        return pd.DataFrame(self.results["runs"])

    @property
    def curves(self) -> pd.DataFrame:
        """One row per point of a friction curve."""
        return self._points("curves")

    @property
    def efficiency(self) -> pd.DataFrame:
        """One row per point of an efficiency curve."""
        return self._points("efficiency")

    @property
    def bands(self) -> pd.DataFrame:
        """One row per pressure that both directions were measured at."""
        return pd.DataFrame(self.results["bands"])

    @property
    def band_trends(self) -> pd.DataFrame:
        """One row per series over pressure; columns such as ``half_slope_n_pa`` and its interval.

        The columns of the two lines begin with ``half`` and ``middle``.
        """
        return pd.json_normalize(self.results["band_trends"], sep="_")

    @property
    def fits(self) -> pd.DataFrame:
        """One row per fitted parameter; joint fits of all loads have no direction and no load."""
        return pd.DataFrame(
            {name: curve.get(name) for name in SERIES_FIELDS}
            | {name: fit[name] for name in _FIT}
            | {"parameter": parameter, **values}
            for curve in [*self.results["curves"], *self.results["joint_fits"]]
            for fit in curve["fits"]
            for parameter, values in fit["parameters"].items()
        )

    @property
    def headline(self) -> pd.DataFrame:
        """One row per direction and load: friction and efficiency at ``v_m_s``, and breakaway.

        Columns such as ``friction_n_u95`` are the half-widths of the 95 % intervals of trials and
        instruments; ``friction_n_basis`` is trials, one_trial, extrapolated, ramp or breakaway.
        """
        return pd.DataFrame(
            {name: value for name, value in series.items() if name not in _HEADLINE}
            | {
                name + ending: None if series[name] is None else series[name][key]
                for name in _HEADLINE
                for ending, key in _HEADLINE_COLUMNS.items()
            }
            for series in self.results["headline"]["series"]
        )

    @property
    def quality(self) -> pd.DataFrame:
        """One row per check of the data: its grade, value and limits.

        The verdict, the worst grade, is ``results["quality"]["grade"]``.
        """
        return pd.DataFrame(self.results["quality"]["checks"])

    @property
    def drift(self) -> dict[str, Any] | None:
        """Drift of steady friction over the campaign, as in ``results.json``.

        None where no point was measured twice at different times.
        """
        return self.results["drift"]

    def samples(self, run: str) -> pd.DataFrame:
        """Return a run's log in SI, one row per sample. Raises ``DataError`` for an unknown run."""
        for screened in screened_runs(self._campaign):
            if screened.run.plan.run == run:
                return pd.DataFrame(channels(screened.run))
        names = [plan.run for plan in self._campaign.plans]
        raise DataError(
            f"{self._campaign.folder}: contains no run {run!r}",
            f"Choose one of {names[0]!r} to {names[-1]!r}." if names else "",
        )

    def _points(self, key: str) -> pd.DataFrame:
        return pd.DataFrame(
            {name: curve[name] for name in SERIES_FIELDS} | point
            for curve in self.results[key]
            for point in curve["points"]
        )


@dataclass(frozen=True)
class FittedCurve(Fit):
    """Friction law fitted to points of one direction."""

    direction: Direction = "extend"

    def predict(self, v_m_s: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Return friction [N] and the half-width of its 95 % interval [N], in the shape of v_m_s.

        ``v_m_s`` [m/s] has the sign of the fitted points. The half-width is t sqrt(c' V c) with the
        parameters' covariance V, the derivatives c of friction by the parameters, and Student's t
        (JCGM 102:2011, 6.2; JCGM 100:2008, G.3). It is that of the law, without the scatter of a
        further measurement, and nan where the points do not determine it. A parameter at an active
        bound counts as known. Outside of the fitted velocities friction is extrapolated: the
        interval holds only if the law does. Raises ``ConfigError``.
        """
        v = np.asarray(v_m_s, dtype=float)
        sign = SIGNS[self.direction]
        if not self.parameters:
            raise ConfigError(f"predict: {self.message}", "Fit more points.")
        if not np.isfinite(v).all() or (sign * v < 0).any() or (np.abs(v) > _FASTEST_M_S).any():
            raise ConfigError(
                f"predict: v_m_s must be finite numbers from 0 to {sign * _FASTEST_M_S:g} m/s, "
                "with the sign of the fitted velocities"
            )
        inputs = np.full((3, v.size), np.nan)
        inputs[0] = np.abs(v).ravel()
        friction, half = predict_friction(CURVE_LAWS[self.law], self, inputs)
        return sign * friction.reshape(v.shape), half.reshape(v.shape)


def load(folder: str | Path, fit: str | Path | Mapping[str, Any] | None = None) -> Campaign:
    """Analyze a campaign as ``hbench analyze`` does, without writing anything.

    ``fit`` is a fit file, or the content of one. Raises ``DataError``, ``ConfigError``.
    """
    if fit is None:
        how = Fitting()
    elif isinstance(fit, Mapping):
        how = parse_fitting(dict(fit), "fit")
    else:
        how = parse_fitting(read_yaml(Path(fit)), str(fit))
    return Campaign(Path(folder), how)


def fit(
    v_m_s: ArrayLike,
    friction_n: ArrayLike,
    law: str = "tustin",
    bounds: Mapping[str, tuple[float, float]] | None = None,
) -> FittedCurve:
    """Fit a law to friction [N] (n,) over velocity [m/s] (n,) of one direction.

    ``law`` is "tustin" (3.2) or "marton_lantos" (3.3); ``bounds`` replace the default
    ones: forces and B of table 6.1, v_s from the lowest to the highest of ``v_m_s``.
    Friction that opposes the motion has the velocity's sign. The result has the parameters with
    their intervals, ``covariance``, ``correlation``, a ``verdict``, and ``predict(v_m_s)``. Raises
    ``ConfigError``.
    """
    v, friction = np.asarray(v_m_s, dtype=float), np.asarray(friction_n, dtype=float)
    if v.ndim != 1 or v.shape != friction.shape or not np.isfinite([v, friction]).all():
        raise ConfigError("fit: v_m_s and friction_n must be finite numbers of equal length")
    if not len(v) or (v == 0).any():
        zeros = f"{np.count_nonzero(v == 0)} of {len(v)} velocities are 0"
        fault = zeros if len(v) else "no points"
        raise ConfigError(f"fit: {fault}", "Give points at speeds above 0, of one direction.")
    if not (v > 0).all() and not (v < 0).all():
        raise ConfigError("fit: velocities have both signs", "Fit each direction separately.")
    if (np.abs(v) > _FASTEST_M_S).any():
        raise ConfigError(
            f"fit: velocity {np.abs(v).max():g} m/s; limit {_FASTEST_M_S:g} m/s",
            "Give velocities in m/s.",
        )
    if law not in CURVE_LAWS:
        raise ConfigError(f"fit: unknown law {law!r}; known are {', '.join(CURVE_LAWS)}")
    direction: Direction = "extend" if (v > 0).all() else "retract"
    points = tuple(_point(*pair) for pair in zip(v.tolist(), friction.tolist(), strict=True))
    curve = Curve("steady", direction, None, None, "", _UNKNOWN, points)
    found = fit_law(CURVE_LAWS[law], [curve], Fitting(), bounds)
    known = {field.name: getattr(found, field.name) for field in fields(Fit)}
    return FittedCurve(**known, direction=direction)


def _point(v_m_s: float, friction_n: float) -> CurvePoint:
    nan = float("nan")
    return CurvePoint(
        v_m_s=v_m_s,
        friction_n=friction_n,
        ci95_n=None,
        n=1,
        f_test_n=nan,
        f_applied_n=nan,
        p_tp_pa=nan,
        p_tr_pa=None,
        trials=(1,),
        trials_n=(friction_n,),
        trials_f_test_n=(nan,),
        runs=(),
    )


def simulate(
    u_v: ArrayLike,
    bench: str | Path | None = None,
    x_m: float | None = None,
    seed: int | None = None,
) -> pd.DataFrame:
    """Simulate a bench's plant alone, from rest, under commands of its three valves.

    ``u_v`` (n, 3) [V] are the commands of the test valve, load valve 1 (rod side) and load valve 2
    (piston side), each applied for 100 us. ``bench`` is a bench file, by default that of
    ``hbench init``; ``x_m`` is the initial position, by default mid-stroke. With a ``seed``, the
    friction scatters from stroke to stroke. Returns n + 1 rows of time, position, velocity,
    pressures, friction of both cylinders and load-cell force. Raises ``ConfigError``.
    """
    commands = np.asarray(u_v, dtype=float)
    if commands.ndim != 2 or commands.shape[1] != 3 or not np.isfinite(commands).all():
        raise ConfigError("simulate: u_v must be rows of three finite voltages")
    file = Path(bench or example_path("bench-aau.yaml"))
    plant = parse_bench(read_yaml(file), str(file))
    par = plant_parameters(plant)
    start_m = 0.5 * plant.test_cylinder.stroke if x_m is None else x_m
    simulated = trajectory(par, initial_state(par, start_m, _START_PA, _START_PA), commands, seed)
    states = {name: simulated.state[:, column] for name, column in _STATE.items()}
    return pd.DataFrame(
        {"t_s": simulated.t_s}
        | states
        | {
            "friction_test_n": simulated.friction_test_n,
            "friction_load_n": simulated.friction_load_n,
            "f_applied_n": simulated.f_applied_n,
        }
    )

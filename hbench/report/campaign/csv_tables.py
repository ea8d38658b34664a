"""Results as CSV (SI, the unit in each name). A number that does not exist is an empty cell.

What else was varied, the factors of imported runs, has a column each.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from statistics import stdev
from typing import Any

from hbench.records import (
    SERIES_FIELDS,
    TEMPERATURES,
    Curve,
    CurvePoint,
    EfficiencyCurve,
    Factors,
    Fit,
    Results,
)
from hbench.report.campaign.results_document import results_json, row
from hbench.report.render.csv_text import csv_text

CsvRow = dict[str, Any]


def runs_csv(results: Results) -> str:
    """Return one row a run, rejected ones included."""
    return _csv(_RUN_COLUMNS, ((run.run.plan.factors, row(run)) for run in results.runs))


def curves_csv(results: Results) -> str:
    """Return one row a point of a friction curve."""
    return _points_csv(results.curves)


def reduced_curves_csv(results: Results) -> str:
    """Return one row a point of a curve reduced to a reference temperature."""
    oil = results.oil_temperature
    reduction = None if oil is None else oil.reduction
    more = {} if reduction is None else {"temp_ref_k": reduction.t_ref_k}
    return _points_csv(() if reduction is None else reduction.curves, more)


def _points_csv(curves: Iterable[Curve], more: CsvRow | None = None) -> str:
    rows = (
        (
            curve.factors,
            {**_series(curve), **vars(point), "runs": " ".join(point.runs), **(more or {})},
        )
        for curve in curves
        for point in curve.points
    )
    extra = () if more is None else ("temp_ref_k", "sigma_temperature_n")
    return _csv((*_CURVE_COLUMNS, *extra), rows)


def fits_csv(results: Results) -> str:
    """Return one row a fitted parameter; its unit is a column.

    A law of all loads has no direction and no load.
    """
    rows = (
        (factors, parameter)
        for factors, series, fit in _all_fits(results)
        for parameter in _fit_rows(series, fit)
    )
    return _csv(_FIT_COLUMNS, rows)


def covariances_csv(results: Results) -> str:
    """Return one row a pair of fitted parameters: their covariance and correlation.

    A pair of a parameter with itself has its variance. The covariance is empty at an active bound,
    and where the data does not determine a parameter.
    """
    rows = (
        (factors, pair)
        for factors, series, fit in _all_fits(results)
        for pair in _covariance_rows(series, fit)
    )
    return _csv(_COVARIANCE_COLUMNS, rows)


def _all_fits(results: Results) -> Iterator[tuple[Factors, CsvRow, Fit]]:
    """Yield the fits of curves, then those of all loads, with their factors and series."""
    for curve in results.curves:
        for fit in curve.fits:
            yield curve.factors, _series(curve), fit
    for joint in results.joint_fits:
        series = dict.fromkeys(SERIES_FIELDS) | {"kind": joint.kind, "label": joint.label}
        for fit in joint.fits:
            yield (), series, fit


def _csv(columns: tuple[str, ...], rows: Iterable[tuple[Factors, CsvRow]]) -> str:
    """Return the text of a table whose factors have a column each, after the label."""
    rows = list(rows)
    names = tuple(dict.fromkeys(name for factors, _ in rows for name, _ in factors))
    after = columns.index("label") + 1
    columns = (*columns[:after], *map(_factor_column, names), *columns[after:])
    return csv_text(
        columns,
        (
            cells | {_factor_column(name): dict(factors).get(name) for name in names}
            for factors, cells in rows
        ),
    )


def _factor_column(name: str) -> str:
    return f"factor_{name}"


def _series(curve: Curve | EfficiencyCurve) -> CsvRow:
    return {name: getattr(curve, name) for name in SERIES_FIELDS}


def _fit_rows(series: CsvRow, fit: Fit) -> list[CsvRow]:
    rows = []
    for name, parameter in fit.parameters.items():
        low, high = parameter.ci95 or (None, None)
        rows.append(
            {
                **series,
                "law": fit.law,
                "parameter": name,
                "value": parameter.value,
                "unit": parameter.unit,
                "se": parameter.se,
                "ci95_low": low,
                "ci95_high": high,
                "at_bound": parameter.at_bound,
                "bias": parameter.bias,
                "disagree": parameter.disagree,
                "rmse_n": fit.rmse_n,
                "converged": fit.converged,
                "verdict": fit.verdict,
                "message": fit.message,
            }
        )
    return rows


def _covariance_rows(series: CsvRow, fit: Fit) -> Iterator[CsvRow]:
    for pair in fit.covariances:
        units = [fit.parameters[name].unit for name in (pair.parameter, pair.with_parameter)]
        yield series | vars(pair) | {"law": fit.law, "unit": " * ".join(units), "dof": fit.dof}


def budget_csv(results: Results) -> str:
    """Return one row an input of a point's uncertainty: its part in friction, with its sign."""
    rows = (
        (curve.factors, _series(curve) | {"v_m_s": point.v_m_s, "input": name, "part_n": part})
        for curve in results.curves
        for point in curve.points
        for name, part in _budget(point).items()
    )
    return _csv(_BUDGET_COLUMNS, rows)


def _budget(point: CurvePoint) -> dict[str, float]:
    """Return the parts [N] of a point's combined standard uncertainty, that of the trials first."""
    parts = dict(point.parts_n)
    if len(point.trials_n) > 1:
        parts = {"trials": stdev(point.trials_n) / math.sqrt(len(point.trials_n))} | parts
    if point.sigma_drift_n is not None:
        parts["drift"] = point.sigma_drift_n
    return parts


def efficiency_csv(results: Results) -> str:
    """Return one row a point of an efficiency curve."""
    rows = (
        (curve.factors, {**_series(curve), **vars(point)})
        for curve in results.efficiency
        for point in curve.points
    )
    return _csv(_EFFICIENCY_COLUMNS, rows)


def bands_csv(results: Results) -> str:
    """Return one row a pressure that both directions were measured at."""
    return _csv(_BAND_COLUMNS, ((band.factors, row(band)) for band in results.bands))


def band_trends_csv(results: Results) -> str:
    """Return two rows a series over pressure: the lines of half band and of middle."""
    rows = []
    for trend in results.band_trends:
        series = {name: getattr(trend, name) for name in ("kind", "label", "p_lr_ref_pa")}
        series |= {"p_low_pa": trend.pressures_pa[0], "p_high_pa": trend.pressures_pa[-1]}
        for name, line in (("half", trend.half), ("middle", trend.middle)):
            rows.append((trend.bands[0].factors, {**series, "quantity": name, **vars(line)}))
    return _csv(_TREND_COLUMNS, rows)


_MEANS = (
    *"friction_n efficiency f_test_n f_applied_n p_tp_pa p_tr_pa".split(),
    *"t_start_s t_stop_s n".split(),
)
_RUN_COLUMNS = (
    *"run kind label direction v_ref_m_s a_ref_m_s2 f_load_n p_lr_ref_pa trial".split(),
    *"accepted reason v_mean_m_s".split(),
    *_MEANS,
    "work_j",
    *TEMPERATURES,
)
_CURVE_COLUMNS = (
    *SERIES_FIELDS,
    *"v_m_s friction_n ci95_n n sigma_instruments_n u95_n u95_dof sigma_drift_n".split(),
    *"f_test_n f_applied_n p_tp_pa p_tr_pa runs temp_k hersey_m".split(),
)
_FIT_COLUMNS = (
    *SERIES_FIELDS,
    *"law parameter value unit se ci95_low ci95_high at_bound bias disagree rmse_n".split(),
    *"converged verdict message".split(),
)
_BUDGET_COLUMNS = (*SERIES_FIELDS, *"v_m_s input part_n".split())
_COVARIANCE_COLUMNS = (
    *SERIES_FIELDS,
    *"law parameter with_parameter covariance unit correlation dof".split(),
)
_BAND_COLUMNS = (
    *"kind label f_load_n p_lr_ref_pa v_m_s p_tp_pa half_n half_ci95_n".split(),
    *"middle_n middle_ci95_n energy_j energy_ci95_j n".split(),
)
_TREND_COLUMNS = (
    *"kind label p_lr_ref_pa p_low_pa p_high_pa quantity".split(),
    *"slope_n_pa slope_ci95_n_pa slope_se_n_pa slope_dof".split(),
    *"intercept_n intercept_ci95_n".split(),
)
_EFFICIENCY_COLUMNS = (
    *SERIES_FIELDS,
    *"v_m_s efficiency sigma sigma_trials sigma_combined ci95 u95 reason".split(),
)


TABLES: dict[str, Callable[[Results], str]] = {
    "results.json": results_json,
    "runs.csv": runs_csv,
    "curves.csv": curves_csv,
    "curves_reduced.csv": reduced_curves_csv,
    "fits.csv": fits_csv,
    "covariances.csv": covariances_csv,
    "budget.csv": budget_csv,
    "efficiency.csv": efficiency_csv,
    "bands.csv": bands_csv,
    "band_trends.csv": band_trends_csv,
}

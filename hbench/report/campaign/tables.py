"""Results as ``results.json`` and as CSV (SI, the unit in each name), and for a terminal.

The names in ``results.json`` (schema "hbench.results/1") are read by other programs and don't
change. A number that does not exist, NaN included, is null there and an empty cell in a CSV.
"""

import json
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from hbench.records import Band, Curve, EfficiencyCurve, Fit, JointFit, Results, ScreenedRun
from hbench.records.rod_pressure import without_common_rod_pressure
from hbench.report.campaign.motion_rows import motion_lines, motions_json
from hbench.report.campaign.reasons import reason_counts
from hbench.report.campaign.series_words import kind_words, load_words
from hbench.report.render.csv_text import csv_text
from hbench.report.render.json_values import plain
from hbench.report.render.numbers import short, span

SCHEMA = "hbench.results/1"

Row = dict[str, Any]


def results_json(results: Results) -> str:
    """Return the text of ``results.json``."""
    document = {
        "schema": SCHEMA,
        "provenance": asdict(results.provenance),
        "runs": [_run(run) for run in results.runs],
        "curves": [
            {
                **_series(curve),
                "specimen": asdict(curve.specimen),
                "points": [asdict(point) for point in curve.points],
                "fits": [_fit(fit) for fit in curve.fits],
                "selection": curve.selection and asdict(curve.selection),
            }
            for curve in results.curves
        ],
        "joint_fits": [
            {
                "kind": joint.kind,
                "label": joint.label,
                "curves": joint.curves,
                "points": joint.points,
                "fits": [_fit(fit) for fit in joint.fits],
                "selection": joint.selection and asdict(joint.selection),
            }
            for joint in results.joint_fits
        ],
        "efficiency": [
            {
                **_series(curve),
                "points": [
                    {**asdict(point), "reason": point.reason or None} for point in curve.points
                ],
                "mean": asdict(curve.mean) if curve.mean else None,
            }
            for curve in results.efficiency
        ],
        "bands": [_band(band) for band in results.bands],
        **motions_json(results.motions),
        "headline": asdict(results.headline),
        "quality": asdict(results.quality),
        "notes": results.notes,
    }
    return json.dumps(plain(document), indent=1, allow_nan=False) + "\n"


def runs_csv(results: Results) -> str:
    """Return one row a run, rejected ones included."""
    return csv_text(_RUN_COLUMNS, map(_run, results.runs))


def curves_csv(results: Results) -> str:
    """Return one row a point of a friction curve."""
    rows = []
    for curve in results.curves:
        for point in curve.points:
            rows.append({**_series(curve), **asdict(point), "runs": " ".join(point.runs)})
    return csv_text(_CURVE_COLUMNS, rows)


def fits_csv(results: Results) -> str:
    """Return one row a fitted parameter; its unit is a column.

    A law of all loads has no direction and no load.
    """
    rows = [
        row
        for curve in results.curves
        for fit in curve.fits
        for row in _fit_rows(_series(curve), fit)
    ]
    for joint in results.joint_fits:
        series = dict.fromkeys(_SERIES) | {"kind": joint.kind, "label": joint.label}
        rows += [row for fit in joint.fits for row in _fit_rows(series, fit)]
    return csv_text(_FIT_COLUMNS, rows)


def _fit_rows(series: Row, fit: Fit) -> list[Row]:
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
                "disagree": parameter.disagree,
                "rmse_n": fit.rmse_n,
                "converged": fit.converged,
                "message": fit.message,
            }
        )
    return rows


def efficiency_csv(results: Results) -> str:
    """Return one row a point of an efficiency curve."""
    rows = [
        {**_series(curve), **asdict(point)}
        for curve in results.efficiency
        for point in curve.points
    ]
    return csv_text(_EFFICIENCY_COLUMNS, rows)


def bands_csv(results: Results) -> str:
    """Return one row a pressure that both directions were measured at."""
    return csv_text(_BAND_COLUMNS, map(_band, results.bands))


def _series(curve: Curve | EfficiencyCurve) -> Row:
    return {
        "kind": curve.kind,
        "label": curve.label,
        "direction": curve.direction,
        "f_load_n": curve.f_load_n,
        "p_lr_ref_pa": curve.p_lr_ref_pa,
        "a_ref_m_s2": curve.a_ref_m_s2,
    }


def _run(screened: ScreenedRun) -> Row:
    plan, means = screened.run.plan, screened.means
    averages = asdict(means) if means else {}
    return {
        "run": plan.run,
        "kind": plan.kind,
        "label": plan.label,
        "direction": plan.direction,
        "v_ref_m_s": plan.v_ref_m_s,
        "a_ref_m_s2": plan.a_ref_m_s2,
        "f_load_n": plan.f_load_n,
        "p_lr_ref_pa": plan.p_lr_ref_pa,
        "trial": plan.trial,
        "accepted": screened.accepted,
        "reason": "; ".join(screened.reasons) or None,
        "reasons": screened.reasons,
        "notes": screened.notes,
        "v_mean_m_s": averages.get("v_m_s"),
        **{name: averages.get(name) for name in _MEANS},
    }


def _band(band: Band) -> Row:
    return {name: getattr(band, name) for name in _BAND_COLUMNS}


def _fit(fit: Fit) -> Row:
    return {
        "law": fit.law,
        "parameters": {name: asdict(value) for name, value in fit.parameters.items()},
        "rmse_n": fit.rmse_n,
        "converged": fit.converged,
        "message": fit.message,
    }


_SERIES = ("kind", "label", "direction", "f_load_n", "p_lr_ref_pa", "a_ref_m_s2")
_MEANS = (
    *"friction_n efficiency f_test_n f_applied_n p_tp_pa p_tr_pa".split(),
    *"t_start_s t_stop_s n".split(),
)
_RUN_COLUMNS = (
    *"run kind label direction v_ref_m_s a_ref_m_s2 f_load_n p_lr_ref_pa trial".split(),
    *"accepted reason v_mean_m_s".split(),
    *_MEANS,
)
_CURVE_COLUMNS = (
    *_SERIES,
    *"v_m_s friction_n ci95_n n sigma_instruments_n u95_n".split(),
    *"f_test_n f_applied_n p_tp_pa p_tr_pa runs".split(),
)
_FIT_COLUMNS = (
    *_SERIES,
    *"law parameter value unit se ci95_low ci95_high at_bound disagree rmse_n".split(),
    *"converged message".split(),
)
_BAND_COLUMNS = (*"kind label f_load_n p_lr_ref_pa p_tp_pa half_n half_ci95_n middle_n n".split(),)
_EFFICIENCY_COLUMNS = (
    *_SERIES,
    *"v_m_s efficiency sigma sigma_trials sigma_combined ci95 u95 reason".split(),
)


def summary_text(results: Results) -> str:
    """Return what a terminal shows: runs, reasons, and a line a curve."""
    accepted = sum(run.accepted for run in results.runs)
    reasons = ", ".join(f"{n} {code}" for code, n in reason_counts(results).most_common())
    rejected = f"{len(results.runs) - accepted} rejected" + (f" ({reasons})" if reasons else "")
    kinds = Counter(run.run.plan.kind for run in results.runs)
    several = len(kinds) > 1 or "steady" not in kinds
    of_kinds = " (" + ", ".join(f"{n} {kind}" for kind, n in kinds.items()) + ")" if several else ""
    rows = [["direction", "load", "speeds mm/s", "friction N", "fit"]]
    for curve in without_common_rod_pressure(results.curves):
        rows.append(
            [
                " ".join(filter(None, (curve.label, kind_words(curve), curve.direction))),
                load_words(curve.f_load_n, curve.p_lr_ref_pa) or "not set",
                span([1e3 * abs(point.v_m_s) for point in curve.points]),
                _friction_words(curve),
                "; ".join(_fit_words(fit) for fit in curve.fits[:1]) or "-",
            ]
        )
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]
    head = f"{results.provenance.name} ({results.provenance.source})"
    counts = f"{len(results.runs)} runs{of_kinds}: {accepted} accepted, {rejected}"
    notes = [f"note: {note}" for note in results.notes]
    lines += [_joint_words(joint) for joint in results.joint_fits]
    table = ["", *lines] if results.curves else []
    moving = motion_lines(results.motions)
    text = "\n".join([head, counts, *table, *([""] if moving else []), *moving, *notes])
    text = text.replace("−", "-").replace("²", "^2")
    return text.replace("–", " to ")  # not every terminal can show them


def _friction_words(curve: Curve) -> str:
    """Write friction against the motion; negative where it was measured along with it."""
    sign = 1 if curve.direction == "extend" else -1
    if len(curve.points) != 1:
        return span([sign * point.friction_n for point in curve.points])
    (point,) = curve.points
    return short(sign * point.friction_n) + (f" +- {short(point.ci95_n)}" if point.ci95_n else "")


def _joint_words(joint: JointFit) -> str:
    label = f"{joint.label}: " if joint.label else ""
    return f"{label}all {joint.curves} curves at once: " + "; ".join(map(_fit_words, joint.fits))


def _fit_words(fit: Fit) -> str:
    words = [
        f"{name}={short(value.value)}" + (f" (at {value.at_bound} bound)" if value.at_bound else "")
        for name, value in fit.parameters.items()
    ]
    return " ".join([fit.law, *words, *([] if fit.converged else ["NOT CONVERGED"])])


TABLES: dict[str, Callable[[Results], str]] = {
    "results.json": results_json,
    "runs.csv": runs_csv,
    "curves.csv": curves_csv,
    "fits.csv": fits_csv,
    "efficiency.csv": efficiency_csv,
    "bands.csv": bands_csv,
}

"""Friction curves with their fits as a MATLAB file (version 5)."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from hbench.records import Curve, Fit, JointFit
from hbench.store.exporting.mat_file import mat_file

_SERIES = "kind direction label f_load_n p_lr_ref_pa a_ref_m_s2".split()
_POINTS = "v_m_s friction_n ci95_n u95_n sigma_instruments_n n".split()
_FIT = "law parameters rmse_n converged message".split()


def mat_curves(curves: Iterable[Curve], joint_fits: Iterable[JointFit]) -> bytes:
    """Return a file with the struct arrays ``curves`` (with ``fits``) and ``joint_fits``.

    A fit's ``parameters`` is a struct of structs: value, se, ci95, at_bound, unit. Missing numbers
    are NaN.
    """
    structs = {
        "curves": _structs([_curve(curve) for curve in curves], [*_SERIES, *_POINTS, "fits"]),
        "joint_fits": _structs([_fit(fit) for joint in joint_fits for fit in joint.fits], _FIT),
    }
    return mat_file(structs)


def _curve(curve: Curve) -> dict[str, Any]:
    row = {name: _or_nan(getattr(curve, name)) for name in _SERIES}
    for name in _POINTS:
        row[name] = np.array([_or_nan(getattr(point, name)) for point in curve.points], dtype=float)
    return row | {"fits": _structs([_fit(fit) for fit in curve.fits], _FIT)}


def _fit(fit: Fit) -> dict[str, Any]:
    parameters = {
        name: {
            "value": p.value,
            "se": _or_nan(p.se),
            "ci95": np.array([_or_nan(end) for end in p.ci95 or (None, None)]),
            "at_bound": p.at_bound or "",
            "unit": p.unit,
        }
        for name, p in fit.parameters.items()
    }
    numbers = {"rmse_n": fit.rmse_n, "converged": fit.converged, "message": fit.message}
    return {"law": fit.law, "parameters": parameters} | numbers


def _structs(rows: list[Mapping[str, Any]], names: list[str]) -> np.ndarray:
    kind = [(name, object) for name in names]
    return np.array([tuple(row[name] for name in names) for row in rows], dtype=kind)


def _or_nan(value: Any) -> Any:
    return np.nan if value is None else value

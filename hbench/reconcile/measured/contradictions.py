"""Contradictions between logs and model that no physical effect explains.

A command that opens its valve the wrong way, pressures whose forces do not fit the cylinder's
areas, and positions outside the stroke are faults of the import map or of the model file. A search
would take them for an effect, so they are looked for first, in windows of motion far from a
reversal:

- ``command_checks.py``: commands against the motion, beyond their valve's limit, of another scale.
- ``force_checks.py``: friction that drives both cylinders, areas that do not fit.
"""

from collections.abc import Sequence

import numpy as np

from hbench.errors import DataError
from hbench.model.parameters import CylinderParameters
from hbench.reconcile.measured.balances import BalanceModel
from hbench.reconcile.measured.command_checks import refuse_commands
from hbench.reconcile.measured.force_checks import (
    diameters_mm,
    fit_areas,
    refuse_areas,
    refuse_driving_friction,
    refuse_one_scale,
)
from hbench.reconcile.measured.moving_windows import moving_windows
from hbench.reconcile.measured.session import Session
from hbench.records import Specimen

_SUPPLY = 0.25  # relative deviation of the median: a source that droops falls by less
# Of the stroke: the zero of a position sensor, or a stated stroke, may be off by so much.
_OUTSIDE = 0.05
_SAME_AREA = 0.02  # relative difference of areas that are stated twice: rounding


def refuse_contradictions(logs: Sequence[Session], model: BalanceModel) -> None:
    """Raise ``DataError`` where positions, commands or forces contradict the logs or the model."""
    specimen = logs[0].runs[0].plan.specimen
    _refuse_stroke(specimen.stroke_m, model.par.test.stroke_m)
    _refuse_areas(specimen, model.par.test)
    _refuse_positions(logs, model.par.test.stroke_m)
    _refuse_supply(logs, model.par.supply.pressure_pa)
    moving = moving_windows(logs, model)
    refuse_commands(moving, model.par.valve.limit_v)
    refuse_driving_friction(moving, model.par)
    p_tp, p_tr, p_lp, p_lr = moving.pressures_pa
    pressures = {"test_cylinder": (p_tp, p_tr), "load_cylinder": (p_lp, p_lr)}
    cylinders = {"test_cylinder": model.par.test, "load_cylinder": model.par.load}
    fits = {}
    for name, cylinder in cylinders.items():
        if fit := fit_areas(cylinder, *pressures[name], moving):
            refuse_areas(name, cylinder, fit)
            fits[name] = fit
    refuse_one_scale(fits, cylinders)


def _refuse_stroke(stated_m: float | None, stroke_m: float) -> None:
    """Raise ``DataError`` for a stroke in the model that is not that of the measured cylinder.

    The volumes of the chambers, and so all flows, follow from it.
    """
    if stated_m is None or abs(stroke_m / stated_m - 1) <= _OUTSIDE:
        return
    raise DataError(
        f"test_cylinder.stroke: {1e3 * stroke_m:.4g} mm in the model file, {1e3 * stated_m:.4g} mm "
        "in the import map or the campaign's bench file (limit: "
        f"{100 * _OUTSIDE:.0f} % difference)",
        "Correct the one that is wrong.",
    )


def _refuse_areas(stated: Specimen, cylinder: CylinderParameters) -> None:
    """Raise ``DataError`` for areas in the model that are not those of the measured cylinder."""
    campaigns = stated.area_piston_m2, stated.area_rod_m2
    models = cylinder.area_piston_m2, cylinder.area_rod_m2
    if min(campaigns) <= 0 or np.allclose(models, campaigns, rtol=_SAME_AREA):
        return
    own, other = (
        "{:.4g} and {:.4g} mm^2 (bore {:.4g} mm, rod {:.4g} mm)".format(
            *(1e6 * area for area in areas), *diameters_mm(*areas)
        )
        for areas in (models, campaigns)
    )
    raise DataError(
        f"test_cylinder: areas of {own} in the model file, {other} in the import map or the "
        f"campaign's bench file (limit: {100 * _SAME_AREA:.0f} % difference)",
        "Correct the one that is wrong. The rod side's area is a ring: piston less rod.",
    )


def _refuse_positions(logs: Sequence[Session], stroke_m: float) -> None:
    """Raise ``DataError`` for positions that the stroke does not contain."""
    low = min(log.channels["x_m"].min() for log in logs)
    high = max(log.channels["x_m"].max() for log in logs)
    if max(-low, high - stroke_m) > _OUTSIDE * stroke_m:
        raise DataError(
            f"x_m: positions from {1e3 * low:.4g} to {1e3 * high:.4g} mm, the stroke of the test "
            f"cylinder in the model file is {1e3 * stroke_m:.4g} mm",
            "Correct test_cylinder.stroke in the model file, or the offset and scale of x_m in the "
            "import map: 0 is the retracted end.",
        )


def _refuse_supply(logs: Sequence[Session], given_pa: float) -> None:
    """Raise ``DataError`` for a supply pressure that is not the model file's."""
    parts = (
        log.channels["p_s_pa"][np.repeat(log.measured["p_s_pa"], np.diff(log.edges))]
        for log in logs
    )
    measured = np.concatenate(list(parts))
    if not len(measured):
        return
    usual_pa = float(np.median(measured))
    if abs(usual_pa / given_pa - 1) > _SUPPLY:
        raise DataError(
            f"p_s_pa: {usual_pa / 1e5:.4g} bar in the median, supply.pressure in the model file is "
            f"{given_pa / 1e5:.4g} bar ({100 * (usual_pa / given_pa - 1):+.0f} %, limit: "
            f"{100 * _SUPPLY:.0f} %)",
            "Correct supply.pressure in the model file, or the unit of p_s_pa in the import map.",
        )

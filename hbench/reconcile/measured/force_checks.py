"""Forces that contradict pressures and motion.

- **Friction** that drives both cylinders: the position counts from the other end, or the pressures
  of both cylinders are exchanged. An error of the load cell raises the friction of one cylinder and
  lowers that of the other.
- **Scale.** The areas by the fit are both larger than those of the model file by more than a load
  cell's gain may be off, or smaller: the force has another unit, or the cylinder is another one.
- **One scale.** Those of one cylinder alone are off: its diameters are wrong. A gain of the load
  cell changes the areas of both cylinders alike.
- **Areas.** The applied force is A_p P_p - A_r P_r less friction (2.12) and inertia, at the load
  cylinder plus friction. A fit of the areas with friction, a mass and an offset gives their ratio.
  Friction is dry, viscous and in proportion to each pressure, so strokes in both directions are
  needed: in one alone, friction that grows with a pressure is like an area. So are pressures that
  differ between the directions alone. What the pressure on the rod side does and friction does not
  must also exceed several times what the fit leaves: friction of another law may do as much. An
  error of the load cell's gain changes both areas alike, so the ratio is free of it. Where both
  areas come out negative, the pressures are exchanged, or the force has the wrong sign.
"""

from collections.abc import Mapping
from math import log, log1p, pi, sqrt
from typing import NamedTuple

import numpy as np

from hbench.analysis.statistics.intervals import covariance_over_runs
from hbench.errors import DataError
from hbench.model.cylinders import pressure_force
from hbench.model.parameters import CylinderParameters, PlantParameters
from hbench.reconcile.measured.command_checks import TURNED_HINT
from hbench.reconcile.measured.moving_windows import FEWEST, SIGMAS, Moving

_AREAS = 0.08  # relative error of the areas' ratio; 11 % or more to the next rod of ISO 3320
_LEAST_SHARE = 0.5  # of the piston's area by the fit
_LEAST_OWN = 0.05  # part of a pressure that neither friction nor the other pressure explains
_SCALE = 1.25  # times both areas: half the step to the next preferred bore of ISO 3320, 1.6 times
_OTHER_SCALE = 3.0  # no cylinder is confused with one whose areas are so much larger
_CLEAR = 3.0  # times the force that the fit leaves: what a wrong area must explain, at least
_VISIBLE = 0.01  # of the applied force: load cells have such errors


def refuse_driving_friction(moving: Moving, par: PlantParameters) -> None:
    """Raise ``DataError`` where the friction of both cylinders has the direction of the motion.

    Offsets cancel in half the difference of both directions.
    """
    v, (p_tp, p_tr, p_lp, p_lr) = moving.v_m_s, moving.pressures_pa
    test, load = (
        pressure_force(p_p, p_r, cylinder)
        for p_p, p_r, cylinder in ((p_tp, p_tr, par.test), (p_lp, p_lr, par.load))
    )
    forces = test - moving.force_n, moving.force_n - load  # against extension
    extends = v > 0
    if min(extends.sum(), (~extends).sum()) < FEWEST or not (moving.force_n.any() and load.any()):
        return
    columns = np.column_stack([np.sign(v), np.ones_like(v)])
    levels = []
    for force in forces:
        fit = np.linalg.lstsq(columns, force, rcond=None)[0]
        covariance, _ = covariance_over_runs(columns, force - columns @ fit, moving.run)
        levels.append(fit[0] + SIGMAS * np.sqrt(covariance[0, 0]))
    if max(levels) < -_VISIBLE * np.sqrt(np.mean(moving.force_n**2)):
        raise DataError(
            f"friction of both cylinders has the direction of the motion (at least "
            f"{-levels[0]:.3g} N at the test cylinder and {-levels[1]:.3g} N at the load cylinder)",
            f"{TURNED_HINT} If x_m is right, exchange the pressures of both cylinders there: "
            "p_tp_pa with p_lp_pa and p_tr_pa with p_lr_pa.",
        )


class AreaFit(NamedTuple):
    """Areas by a fit of the applied force, in shares of those of the model file."""

    piston: float
    rod: float
    se: np.ndarray  # (2,)
    own: tuple[float, float]  # part of each pressure that the other terms do not explain
    rod_n: float  # norm over the windows of the force of the model's rod side by its own part
    left_n: float  # norm of the force that the fit leaves

    @property
    def scale(self) -> float:
        """Geometric mean of both."""
        return sqrt(self.piston * self.rod)

    @property
    def scale_error(self) -> float:
        """Relative standard error of the scale, without the correlation of both."""
        return float(np.hypot(*(self.se / (self.piston, self.rod)))) / 2

    @property
    def has_scale(self) -> bool:
        """Whether the force follows both pressures beyond doubt."""
        sure = self.piston > SIGMAS * self.se[0] and self.rod > SIGMAS * self.se[1]
        return bool(sure and self.rod * self.rod_n > _CLEAR * self.left_n)


def fit_areas(
    cylinder: CylinderParameters, p_p: np.ndarray, p_r: np.ndarray, moving: Moving
) -> AreaFit | None:
    """Fit a cylinder's areas to the applied force; None where the windows do not determine them."""
    v, piston_m2, rod_m2 = moving.v_m_s, cylinder.area_piston_m2, cylinder.area_rod_m2
    way = np.sign(v)
    friction = way, v, way * p_p, way * p_r
    inertia = moving.a_m_s2, np.ones_like(v)
    columns = np.column_stack([p_p * piston_m2, -p_r * rod_m2, *friction, *inertia])
    size = np.linalg.norm(columns, axis=0)
    if min(np.sum(way > 0), np.sum(way < 0)) < FEWEST or not size.all():
        return None
    columns = columns / size
    fit = np.linalg.lstsq(columns, moving.force_n, rcond=None)[0]
    left = moving.force_n - columns @ fit
    covariance, _ = covariance_over_runs(columns, left, moving.run)
    (piston, rod), se = fit[:2] / size[:2], np.sqrt(np.diag(covariance)[:2]) / size[:2]
    if not np.isfinite(se).all():
        return None
    own = _own_part(columns, 0), _own_part(columns, 1)
    return AreaFit(piston, rod, se, own, size[1] * own[1], float(np.linalg.norm(left)))


def refuse_areas(name: str, cylinder: CylinderParameters, fit: AreaFit) -> None:
    """Raise ``DataError`` for areas that do not fit.

    The standard error of the ratio leaves out the correlation of both areas.
    """
    piston, rod, se, own, rod_n, left_n = fit
    piston_m2, rod_m2 = cylinder.area_piston_m2, cylinder.area_rod_m2
    clear = _CLEAR * left_n
    if piston < -SIGMAS * se[0] and rod < -SIGMAS * se[1] and -rod * rod_n > clear:
        raise _negative_areas(name, piston, rod, rod_m2 / piston_m2)
    if fit.has_scale and abs(log(fit.scale)) - SIGMAS * fit.scale_error > log(_SCALE):
        raise _other_scale(name, cylinder, fit)
    if min(own) < _LEAST_OWN:
        return  # friction may follow the pressures
    if piston < max(_LEAST_SHARE, SIGMAS * se[0]):
        return  # the force does not follow the pressures
    if abs(rod - piston) * rod_n < clear:
        return  # friction of another law may do the same
    off, error = rod / piston - 1, np.hypot(*se) / piston
    if abs(off) > max(_AREAS, SIGMAS * error):
        given, found = rod_m2 / piston_m2, rod_m2 / piston_m2 * (1 + off)
        raise DataError(
            f"{name}: pressures and force give a ratio of rod side to piston side area of "
            f"{found:.3f}, the model file {given:.3f} ({100 * off:+.0f} %, limit: "
            f"{100 * _AREAS:.0f} %){_fitting_rod(piston_m2, found)}",
            "Correct the cylinder's diameters in the model file, or the scale of a pressure in the "
            "import map.",
        )


def refuse_one_scale(
    fits: Mapping[str, AreaFit], cylinders: Mapping[str, CylinderParameters]
) -> None:
    """Raise ``DataError`` where the areas of one of both cylinders, by name, are off.

    The gain of the load cell changes those of both by the same factor.
    """
    if len(fits) < 2 or not all(fit.has_scale for fit in fits.values()):
        return
    right, wrong = sorted(fits, key=lambda name: abs(log(fits[name].scale)))
    off = fits[wrong].scale / fits[right].scale
    error = np.hypot(fits[wrong].scale_error, fits[right].scale_error)
    if abs(log(off)) - SIGMAS * error < log1p(_AREAS):
        return
    cylinder, gain = cylinders[wrong], fits[right].scale
    bore, rod = diameters_mm(
        fits[wrong].piston / gain * cylinder.area_piston_m2,
        fits[wrong].rod / gain * cylinder.area_rod_m2,
    )
    raise DataError(
        f"{wrong}: pressures and force give areas of {_percent(fits[wrong])} % of the model "
        f"file's, those of {right} {_percent(fits[right])} % (limit of the difference: "
        f"{100 * _AREAS:.0f} %)",
        f"Correct the diameters of {wrong} in the model file (a bore of {bore:.3g} mm and a rod "
        f"of {rod:.3g} mm would fit), or the scale of its pressures in the import map.",
    )


def _percent(fit: AreaFit) -> str:
    return f"{100 * fit.piston:.0f} and {100 * fit.rod:.0f}"


def _other_scale(name: str, cylinder: CylinderParameters, fit: AreaFit) -> DataError:
    """Return the error for areas that are both off."""
    piston, rod, scale = fit.piston, fit.rod, fit.scale
    map_hint = "the unit or scale of f_applied_n, or of the pressures, in the import map"
    bore, rod_mm = diameters_mm(piston * cylinder.area_piston_m2, rod * cylinder.area_rod_m2)
    is_cylinder = 1 / _OTHER_SCALE < scale < _OTHER_SCALE
    return DataError(
        f"{name}: f_applied_n is {scale:.2g} times the forces of the pressures (areas by a fit: "
        f"{100 * piston:.0f} and {100 * rod:.0f} % of the model file's)",
        f"Correct the cylinder's diameters in the model file (a bore of {bore:.3g} mm and a rod of "
        f"{rod_mm:.3g} mm would fit), or {map_hint}."
        if is_cylinder
        else f"Correct {map_hint}.",
    )


def _negative_areas(name: str, piston: float, rod: float, ratio: float) -> DataError:
    """Return the error for areas by the fit that are negative, in shares of the model file's."""
    side = name.removesuffix("_cylinder")
    exchanged = abs(np.log(rod / piston) + 2 * np.log(ratio)) < abs(np.log(rod / piston))
    p_p, p_r = ("p_tp_pa", "p_tr_pa") if side == "test" else ("p_lp_pa", "p_lr_pa")
    return DataError(
        f"{name}: the force falls where {p_p} rises, and rises with {p_r} (areas by a fit: "
        f"{100 * piston:.0f} and {100 * rod:.0f} % of the model file's)",
        f"Exchange the columns of {p_p} and {p_r} in the import map."
        if exchanged
        else "Give f_applied_n scale: -1 in the import map: positive, it opposes extension.",
    )


def _own_part(columns: np.ndarray, which: int) -> float:
    """Return the length of a column (n,) of length 1 that the others (n, p - 1) leave over."""
    others = np.delete(columns, which, axis=1)
    left = columns[:, which] - others @ np.linalg.lstsq(others, columns[:, which], rcond=None)[0]
    return float(np.linalg.norm(left))


def diameters_mm(piston_m2: float, rod_m2: float) -> tuple[float, float]:
    """Return bore and rod of a cylinder's areas."""
    return 1e3 * sqrt(4 * piston_m2 / pi), 1e3 * sqrt(4 * max(piston_m2 - rod_m2, 0.0) / pi)


def _fitting_rod(piston_m2: float, ratio: float) -> str:
    """Return which rod would have an area ratio; empty for a ratio that no rod has."""
    if not 0 < ratio < 1:
        return ""
    bore_mm = 1e3 * sqrt(4 * piston_m2 / pi)
    return (
        f"; with the bore of {bore_mm:.4g} mm a rod of {bore_mm * sqrt(1 - ratio):.3g} mm would fit"
    )

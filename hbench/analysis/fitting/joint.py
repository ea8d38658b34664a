"""Fits of a campaign: laws of single curves, joint laws of all loads, and their selection."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

from hbench.analysis.fitting.fit import JOINT_LAWS, fit_law, fits
from hbench.analysis.fitting.selection import select, select_joint, with_held_out
from hbench.config.fitting import Fitting
from hbench.config.setup import ANYWHERE, Reach
from hbench.records import Curve, JointFit


def fitted(curve: Curve, how: Fitting, reach: Reach = ANYWHERE) -> Curve:
    """Return the curve with its fits and the selection among them."""
    of_laws = (with_held_out(fit, [curve], how) for fit in fits(curve, how, reach))
    with_fits = replace(curve, fits=tuple(of_laws))
    return replace(with_fits, selection=select(with_fits))


def joint_fits(
    curves: Sequence[Curve], how: Fitting, reach: Reach = ANYWHERE
) -> tuple[JointFit, ...]:
    """Fit the joint laws of all loads to the curves of each kind and label.

    Only curves with fits of their own are used, and at least two: one curve does not distinguish
    the effects of pressure and speed.
    """
    names = [name for name in how.laws if name in JOINT_LAWS]
    groups: dict[tuple, list[Curve]] = defaultdict(list)
    for curve in curves:
        if curve.fits and any(point.p_tr_pa is not None for point in curve.points):
            groups[curve.kind, curve.label, curve.specimen].append(curve)
    return tuple(
        _joint(group, names, how, reach) for group in groups.values() if names and len(group) > 1
    )


def _joint(curves: Sequence[Curve], names: Sequence[str], how: Fitting, reach: Reach) -> JointFit:
    of_laws = (fit_law(JOINT_LAWS[name], curves, how, reach=reach) for name in names)
    fits_of_laws = tuple(with_held_out(fit, curves, how) for fit in of_laws)
    points = [p for curve in curves for p in curve.points if p.p_tr_pa is not None]
    return JointFit(
        kind=curves[0].kind,
        label=curves[0].label,
        curves=len(curves),
        points=len(points),
        fits=fits_of_laws,
        selection=select_joint(curves, fits_of_laws),
    )

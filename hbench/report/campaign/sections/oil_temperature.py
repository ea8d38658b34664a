"""Section of the page on the oil's temperature, and friction at a reference temperature."""

from collections.abc import Iterable
from dataclasses import replace
from statistics import fmean

from hbench.records import DIRECTION_WORDS, Curve, OilTemperature, Reduction, Results
from hbench.records.rod_pressure import series_key, without_common_rod_pressure
from hbench.records.summary import SEPARATED_VIF
from hbench.report.campaign.fit_tables import fit_tables, law_words
from hbench.report.campaign.table_columns import WHO, table, who
from hbench.report.drift import drift_words
from hbench.report.oil_words import PLACES, celsius
from hbench.report.render.document import Section
from hbench.report.render.figures import Drawing
from hbench.report.render.numbers import number, p_words, significant, with_interval
from hbench.report.render.word_tables import Table

_LEFT = "Friction is not reduced to a reference temperature, since "


def temperature_section(results: Results, drawings: tuple[Drawing, ...]) -> tuple[Section, ...]:
    """Return the temperature of each curve and the reduced friction; nothing if not measured."""
    oil = results.oil_temperature
    if oil is None:
        return ()
    measured = (
        f"The oil's temperature was measured {PLACES[oil.sensor]}. In the accepted steady runs it "
        f"was {celsius(oil.mean_k)} °C in the mean, from {celsius(oil.low_k)} to "
        f"{celsius(oil.high_k)} °C."
    )
    reduction = oil.reduction
    text = (measured, *(_reduction_words(reduction) if reduction else [f"{_LEFT}{oil.reason}."]))
    tables = [replace(_curve_table(results, oil), title="Oil temperature of each curve")]
    parts: list[Section] = []
    if reduction is not None:
        tables.append(replace(_effect_table(reduction), title="Effect of the viscosity"))
        parts += _reduced_parts(results, reduction)
    section = Section(
        "Oil temperature",
        text,
        drawings=drawings,
        tables=tuple(tables),
        parts=tuple(parts),
        anchor="temperature",
    )
    return (section,)


def _reduction_words(reduction: Reduction) -> Iterable[str]:
    ref = celsius(reduction.t_ref_k)
    if reduction.curves:
        outside = (
            " The reference temperature is outside the measured ones: extrapolated."
            if reduction.extrapolated
            else ""
        )
        yield (
            f"Friction of {len(reduction.curves)} curves is reduced to {ref} °C by its dependence "
            f"on viscosity, estimated from the trials of each point.{outside} The headline, the "
            "efficiency and the other sections show friction as it was measured."
        )
    left = [effect for effect in reduction.effects if effect.reason]
    for effect in left:
        series = ", ".join(filter(None, (effect.label, DIRECTION_WORDS[effect.direction])))
        start = series[:1].upper() + series[1:]
        yield f"{start}: friction is not reduced to {ref} °C, since {effect.reason}."
    if any(effect.speed_vif > SEPARATED_VIF for effect in left):
        yield "Repeat the campaign with order: random in the schedule."
    if reduction.drift is not None:
        yield f"After the reduction, steady friction changed by {drift_words(reduction.drift)}."


def _reduced_parts(results: Results, reduction: Reduction) -> Iterable[Section]:
    if not reduction.curves:
        return
    reduced = replace(results, curves=reduction.curves, joint_fits=())
    fits = tuple(
        replace(each, title=f"{law_words(law)}, at {celsius(reduction.t_ref_k)} °C")
        for law, each in fit_tables(reduced).items()
    )
    if fits:
        yield Section(
            "Parameters of the reduced curves",
            ("Their intervals do not include the uncertainty of the correction.",),
            tables=fits,
        )
    points = _reduced_points(results, reduction)
    title = f"Points of the reduced curves ({len(points.rows)})"
    yield Section(title, tables=(points,), folded=True)


def _reduced_points(results: Results, reduction: Reduction) -> Table:
    measured = {_key(curve): curve for curve in results.curves}
    rows = [
        (
            *who(shown),
            number(1e3 * after.v_m_s, 2),
            "" if after.temp_k is None else celsius(after.temp_k),
            with_interval(before.friction_n, before.ci95_n),
            with_interval(after.friction_n, after.ci95_n),
            "" if after.u95_n is None else significant(after.u95_n, 2),
        )
        for curve, shown in zip(
            reduction.curves, without_common_rod_pressure(reduction.curves), strict=True
        )
        for before, after in zip(measured[_key(curve)].points, curve.points, strict=True)
    ]
    head = (
        *("Velocity (mm/s)", "Oil (°C)", "Measured (N)"),
        f"At {celsius(reduction.t_ref_k)} °C (N)",
        "U with correction (N)",
    )
    return table((*WHO, *head), rows)


def _curve_table(results: Results, oil: OilTemperature) -> Table:
    corrected = {_key(curve): curve for curve in oil.reduction.curves} if oil.reduction else {}
    measured = [curve for curve in results.curves if curve.temp_range_k is not None]
    rows = []
    for curve, shown in zip(measured, without_common_rod_pressure(measured), strict=True):
        low, high = curve.temp_range_k or (0.0, 0.0)
        mean = fmean(point.temp_k for point in curve.points if point.temp_k is not None)
        reduced = corrected.get(_key(curve))
        rows.append(
            (
                *who(shown),
                celsius(mean),
                celsius(low),
                celsius(high),
                "–" if reduced is None else _largest_change(curve, reduced),
            )
        )
    head = ("Mean (°C)", "Lowest (°C)", "Highest (°C)", "Largest correction (N)")
    return table((*WHO, *head), rows)


def _key(curve: Curve) -> tuple:
    return curve.kind, *series_key(curve), curve.specimen


def _largest_change(curve: Curve, reduced: Curve) -> str:
    changes = [
        curve.against_motion * (after.friction_n - before.friction_n)
        for before, after in zip(curve.points, reduced.points, strict=True)
    ]
    return number(max(changes, key=abs), 0)


def _effect_table(reduction: Reduction) -> Table:
    rows = [
        (
            effect.label,
            DIRECTION_WORDS[effect.direction],
            with_interval(effect.dry_n, effect.dry_ci95_n),
            with_interval(effect.viscous_n_s_m, effect.viscous_ci95_n_s_m),
            with_interval(effect.correction_n, effect.correction_ci95_n),
            p_words(effect.p),
            str(effect.points),
            str(effect.trials),
            number(effect.speed_vif),
            "no" if effect.reason else "yes",
        )
        for effect in reduction.effects
    ]
    head = (
        *("Label", "Direction", "c_0 (N)", "c_1 (N s/m)", "Largest correction (N)", "p"),
        *("Points", "Trials", "VIF of viscosity by speed", "Reduced"),
    )
    return table(head, rows, words=("Reduced",))

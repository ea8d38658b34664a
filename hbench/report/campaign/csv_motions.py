"""CSV files (SI) of the results of moving and resting runs."""

from collections.abc import Callable

from hbench.records import Results
from hbench.report.campaign.results_document import row
from hbench.report.render.csv_text import csv_text

_SERIES = ("kind", "label", "f_load_n", "p_lr_ref_pa")


def comparisons_csv(results: Results) -> str:
    """Return one row a comparison, with all its accelerations in one cell."""
    rows = (
        {**row(comparison), "a_m_s2": " ".join(map(repr, comparison.a_m_s2))}
        for comparison in results.motions.comparisons
    )
    columns = "direction what a_m_s2 v_low_m_s v_high_m_s effect_n ci95_n p_value p_holm n message"
    return csv_text((*_SERIES, *columns.split()), rows)


def loops_csv(results: Results) -> str:
    """Return one row a width of a loop, with the loop's own numbers in each."""
    rows = (
        {**shared, **vars(width)}
        for loop in results.motions.loops
        for shared in [row(loop)]
        for width in loop.widths
    )
    columns = "v_top_m_s a_m_s2 cycles trials unit area_j area_ci95_j v_m_s width_n ci95_n board_n"
    return csv_text((*_SERIES, *columns.split()), rows)


def loop_traces_csv(results: Results) -> str:
    """Return the mean loops, in the order of time."""
    rows = (
        {**shared, "x_m": x, "v_m_s": v, "friction_n": friction}
        for loop in results.motions.loops
        for shared in [row(loop)]  # once: it holds the whole trace
        for x, v, friction in loop.trace
    )
    return csv_text((*_SERIES, "v_top_m_s", "x_m", "v_m_s", "friction_n"), rows)


def levels_csv(results: Results) -> str:
    """Return one row a step of the reference."""
    rows = ({**row(level), "runs": " ".join(level.runs)} for level in results.motions.levels)
    columns = (
        "number v_from_m_s v_to_m_s before_n after_n after_ci95_n overshoot_n overshoot_ci95_n "
        "settling_s settling_ci95_s settling_step_s n runs remark"
    )
    return csv_text((*_SERIES, *columns.split()), rows)


def leakage_csv(results: Results) -> str:
    """Return one row a leak."""
    rows = []
    for leakage in results.motions.leakages:
        for coefficient in leakage.coefficients:
            low, high = coefficient.ci95 or (None, None)
            cells = {
                "leak": coefficient.name,
                "value_m3_s_pa": coefficient.value,
                "se_m3_s_pa": coefficient.se,
            }
            cells |= {"ci95_low_m3_s_pa": low, "ci95_high_m3_s_pa": high}
            rows.append({**vars(leakage), **cells})
    columns = (
        "kind label leak value_m3_s_pa se_m3_s_pa ci95_low_m3_s_pa ci95_high_m3_s_pa "
        "exponent exponent_ci95 reference_pa bulk_modulus_pa message"
    )
    return csv_text(tuple(columns.split()), rows)


def decays_csv(results: Results) -> str:
    """Return one row a hold."""
    rows = (
        {"kind": leakage.kind, **row(decay)}
        for leakage in results.motions.leakages
        for decay in leakage.decays
    )
    columns = "run p_p_pa p_r_pa rate_p_pa_s rate_r_pa_s out_p_m3_s out_r_m3_s"
    return csv_text((*_SERIES, *columns.split()), rows)


def decay_traces_csv(results: Results) -> str:
    """Return the oil that has left each side over the time of each hold."""
    rows = (
        {"kind": leakage.kind, **shared, "t_s": t_s, "out_p_m3": out_p, "out_r_m3": out_r}
        for leakage in results.motions.leakages
        for decay in leakage.decays
        for shared in [row(decay)]
        for t_s, out_p, out_r in decay.trace
    )
    return csv_text((*_SERIES, "run", "t_s", "out_p_m3", "out_r_m3"), rows)


def breakaways_csv(results: Results) -> str:
    """Return one row a direction, load, dwell and rate."""
    rows = ({**row(each), "runs": " ".join(each.runs)} for each in results.motions.breakaways)
    columns = (
        "direction dwell_s rate_n_s breakaway_n ci95_n u95_n n displacement_m p_tp_pa p_tr_pa "
        "f_applied_n breakaway_pa u95_pa runs"
    )
    return csv_text((*_SERIES, *columns.split()), rows)


def dwell_laws_csv(results: Results) -> str:
    """Return one row a law of breakaway over the time at rest."""
    columns = "direction law f_1s_n f_1s_ci95_n growth growth_ci95 rmse_n dwells n"
    return csv_text((*_SERIES, *columns.split()), map(row, results.motions.dwell_laws))


def zeros_csv(results: Results) -> str:
    """Return one row a sensor of each zero check; errors and limits in Pa or N."""
    rows = (
        {**vars(check), **vars(zero)}
        for check in results.motions.zero_checks
        for zero in check.zeros
    )
    columns = "kind run time_s pressure_pa pressure_limit_pa channel error limit"
    return csv_text(tuple(columns.split()), rows)


def surface_csv(results: Results) -> str:
    """Return one row a point of a surface."""
    rows = (
        {**vars(surface), "f_load_n": load, "v_m_s": v, "friction_n": friction, "ci95_n": interval}
        for surface in results.motions.surfaces
        for load, of_load, intervals in zip(
            surface.f_load_n, surface.friction_n, surface.ci95_n, strict=True
        )
        for v, friction, interval in zip(surface.v_m_s, of_load, intervals, strict=True)
    )
    columns = "kind label direction p_lr_ref_pa f_load_n v_m_s friction_n ci95_n"
    return csv_text(tuple(columns.split()), rows)


def over_distance_csv(results: Results) -> str:
    """Return one row a value, with the trend of its series in each."""
    rows = (
        {**shared, "at_m": at_m, "value": value}
        for trend in results.motions.over_distance
        for shared in [row(trend)]
        for at_m, value in zip(trend.distance_m, trend.values, strict=True)
    )
    columns = (
        "direction quantity v_m_s dwell_s at_m value slope slope_ci95 p p_holm last_from_m "
        "last_mean last_change last_change_ci95 verdict"
    )
    return csv_text((*_SERIES, *columns.split()), rows)


def motion_tables(results: Results) -> dict[str, str]:
    """Return the text of each of ``MOTION_TABLES`` that has rows, by its file's name."""
    texts = {name: table(results) for name, table in MOTION_TABLES.items()}
    return {name: text for name, text in texts.items() if len(text.splitlines()) > 1}


MOTION_TABLES: dict[str, Callable[[Results], str]] = {
    "comparisons.csv": comparisons_csv,
    "loops.csv": loops_csv,
    "loop_traces.csv": loop_traces_csv,
    "levels.csv": levels_csv,
    "leakage.csv": leakage_csv,
    "decays.csv": decays_csv,
    "decay_traces.csv": decay_traces_csv,
    "breakaways.csv": breakaways_csv,
    "dwell_laws.csv": dwell_laws_csv,
    "zeros.csv": zeros_csv,
    "surface.csv": surface_csv,
    "over_distance.csv": over_distance_csv,
}

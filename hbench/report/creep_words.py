"""Why a measured breakaway can be below the friction of slow steady motion, in words."""

from hbench.records import KINDS, Results
from hbench.report.campaign.series_words import TITLES
from hbench.report.render.numbers import number, short


def creep_facts(results: Results) -> tuple[tuple[str, str], ...]:
    """Explain a breakaway below the friction of a slower steady run of its direction and load.

    The piston creeps faster then: friction at a higher steady speed is lower. Empty elsewhere.
    """
    facts = []
    for each in results.motions.breakaways:
        points = [
            (abs(point.v_m_s), abs(point.friction_n))
            for curve in results.curves
            if KINDS[curve.kind].has_constant_speed
            and (curve.direction, curve.f_load_n, curve.p_lr_ref_pa)
            == (each.direction, each.series.f_load_n, each.series.p_lr_ref_pa)
            for point in curve.points
        ]
        slower = [point for point in points if point[0] < (each.v_m_s or 0.0)]
        faster = [point for point in points if point[0] > (each.v_m_s or 0.0)]
        if not slower or not faster or not min(faster)[1] < each.breakaway_n < max(slower)[1]:
            continue
        (low, before), (high, after) = max(slower), min(faster)
        largest, crawl = number(each.breakaway_n, 0), short(1e3 * low)
        facts.append(
            (
                f"Breakaway below friction, {TITLES[each.direction].lower()}",
                f"{largest} N is below the {number(before, 0)} N of steady runs at {crawl} mm/s. "
                "It is the largest friction during the force ramp, reached after "
                f"{number(1e3 * each.displacement_m, 1)} mm of creep at "
                f"{number(1e3 * (each.v_m_s or 0.0), 1)} mm/s, and not a friction at rest. When "
                f"the ramp passed {crawl} mm/s, friction was less than {largest} N: after a rest, "
                "it takes some travel to build up to that of steady motion. At higher speeds, "
                f"friction falls, to {number(after, 0)} N at {short(1e3 * high)} mm/s.",
            )
        )
    return tuple(facts)

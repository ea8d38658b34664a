"""Direction, load and kind of a series of runs in words."""

from typing import TypeAlias

from hbench.records import (
    KINDS,
    Curve,
    EfficiencyCurve,
    HeadlineSeries,
    ImplausiblePoint,
    PointTrials,
    RunPlan,
)
from hbench.report.render.numbers import force, short
from hbench.units import from_si

AnySeries: TypeAlias = (
    Curve | EfficiencyCurve | HeadlineSeries | ImplausiblePoint | PointTrials | RunPlan
)

TITLES = {"extend": "Extending", "retract": "Retracting"}  # of directions


def load_words(f_load_n: float | None, p_lr_ref_pa: float | None) -> str:
    """Write the references of the load cylinder, such as ``500 N, 15 bar``; empty without any."""
    references = [] if f_load_n is None else [force(f_load_n)]
    if p_lr_ref_pa is not None:
        references.append(f"{short(from_si(p_lr_ref_pa, 'bar'))} bar")
    return ", ".join(references)


def kind_words(series: AnySeries) -> str:
    """Write a kind of experiment, such as ``ramp 0.1 m/s²``; empty for steady runs."""
    kind = KINDS[series.kind]
    if kind.is_ramp and series.a_ref_m_s2 is not None:
        return f"{kind.display_name} {short(series.a_ref_m_s2)} m/s²"
    return "" if kind.has_constant_speed else kind.display_name

"""The gaps of single runs: the worst as a table, all of them as CSV."""

from collections.abc import Mapping

from hbench.records import KINDS, BeforeAfter, Diagnosis, GapTable, RunPlan, WordTable
from hbench.report.campaign.series_words import load_words
from hbench.report.diagnosis.names import STEPS, balance, gap_number, signal, steps_of
from hbench.report.render.csv_text import csv_text
from hbench.report.render.numbers import NONE, short
from hbench.report.render.word_tables import with_columns

_PLAN = ("kind", "label", "direction", "v_ref_m_s", "f_load_n", "p_lr_ref_pa", "trial")
_PARTS = ("balances", "signals", "open_loop")
_COLUMNS = ("run", *_PLAN, "held_out", "of", "name", *STEPS)


def run_gaps_csv(diagnosis: Diagnosis) -> str:
    """Return a row for each run and balance or signal, in the campaign's order.

    ``of`` is balances, signals (closed loop) or open_loop; each run begins with all its balances.
    """
    rows = []
    for run_gap in diagnosis.gap_runs:
        about = {"run": run_gap.plan.run, **{name: getattr(run_gap.plan, name) for name in _PLAN}}
        about["held_out"] = run_gap.held_out
        groups: dict[str, Mapping[str, BeforeAfter]] = {
            group: getattr(run_gap.gap, group) for group in _PARTS
        }
        groups["balances"] = {"all": run_gap.gap.total, **groups["balances"]}
        for group, gaps in groups.items():
            for name, gap in gaps.items():
                rows.append({**about, "of": group, "name": name, **vars(gap)})
    return csv_text(_COLUMNS, rows)


def run_table(diagnosis: Diagnosis, most: int) -> WordTable:
    """Return the ``most`` worst runs, by the balances of the model with its effects."""
    compared = [run_gap for run_gap in diagnosis.gap_runs if run_gap.gap.balances]
    chosen = sorted(compared, key=lambda run_gap: -run_gap.gap.total.after)[:most]
    steps = steps_of(diagnosis)
    title = "Gap of each run"
    if len(chosen) < len(compared):
        title += f" (the worst {len(chosen)} of {len(compared)})"
    rows = [
        (
            run_gap.plan.run,
            plan_words(run_gap.plan),
            "no" if run_gap.held_out else "yes",
            *(gap_number(getattr(run_gap.gap.total, step)) for step in steps),
            *_worst(run_gap.gap),
        )
        for run_gap in chosen
    ]
    head = ("run", "what", "in the fit", *steps.values())
    head += ("flow or force", "signal, closed loop", "open loop")
    several = {name for each in compared for name in each.gap.balances}
    kept = [i for i in range(len(head)) if any(row[i] != NONE for row in rows)]
    kept = [i for i in kept if head[i] != "flow or force" or len(several) > 1]
    return with_columns(WordTable(title, head, tuple(rows)), kept)


def plan_words(plan: RunPlan) -> str:
    """Return what a run was: its experiment, speed, load and trial."""
    speed = plan.kind
    if plan.v_ref_m_s:  # of imported runs at several speeds it is the largest measured one
        several = plan.motion is None and KINDS[plan.kind].covers_speeds
        largest, signed = f"up to {short(1e3 * abs(plan.v_ref_m_s))}", short(1e3 * plan.v_ref_m_s)
        speed = f"{plan.kind} {largest if several else signed} mm/s"
    load = load_words(plan.f_load_n, plan.p_lr_ref_pa)
    label = plan.label.removesuffix(plan.run).strip()  # strokes of one file are runs of their own
    return ", ".join(filter(None, (label, speed, load, f"trial {plan.trial}")))


def _worst(gap: GapTable) -> tuple[str, ...]:
    cells = []
    for group, display_name in zip(_PARTS, (balance, signal, signal), strict=True):
        gaps: Mapping[str, BeforeAfter] = getattr(gap, group)
        name = max(gaps, key=lambda name: gaps[name].after, default=None)
        cells.append(f"{display_name(name).title} {gap_number(gaps[name].after)}" if name else NONE)
    return tuple(cells)

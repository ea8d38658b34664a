"""Verification of identified laws: a model of the bench follows the measured profile (5.5).

The model is the bench file with the test cylinder's friction replaced, without scatter and sensor
noise, under the firmware in closed loop. It makes the measured runs, and before them the preceding
run of the campaign, so that bristles and oil start in the same state.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from hbench.analysis.identification.verification import model_errors, steady_parts
from hbench.analysis.screening.sample_friction import logged_motion
from hbench.config.bench import Plant, merge, parse_bench, parse_plant
from hbench.experiment.closed_loop import record_plans
from hbench.experiment.progress import Report, report_of_part
from hbench.records import Followed, IdentifiedLaw, Run, RunPlan, Trace

_EXACT = {
    "friction": {"load": {"scatter": "0 %"}},
    "sensors": {"adc": {"noisy": False, "quantised": False}},
}


@dataclass(frozen=True)
class VerifiedLaws:
    """Identified laws with their errors, and the measured and modelled curves."""

    laws: tuple[IdentifiedLaw, ...]
    followed: tuple[Followed, ...]


def verify_laws(
    bench_data: dict[str, Any],
    laws: Sequence[IdentifiedLaw],
    measured: Sequence[Run],
    campaign_plans: Sequence[RunPlan],
    report: Report,
) -> VerifiedLaws:
    """Simulate the ``measured`` verification runs with each identified law, and compare both.

    ``bench_data`` is the content of the bench file, ``campaign_plans`` are all runs of the campaign
    in order. The measured runs must have a motion and v_ref. Where the model's board stops itself,
    the runs before that are compared and ``not_verified`` has the reason. Raises ``DataError`` for
    a log without a channel that friction needs.
    """
    bench = parse_bench(bench_data, "bench")
    mass_kg = bench.moving_mass.test
    wanted = {run.plan.run for run in measured}
    chosen = _with_preceding_runs(campaign_plans, wanted)
    plans = [replace(plan, run=f"{i:04d}") for i, plan in enumerate(chosen, 1)]
    fitted = [law for law in laws if law.fit is not None]
    verified, runs_of_law = {}, {}
    for number, law in enumerate(fitted):
        of_law = report_of_part(report, number, len(fitted), len(plans))
        recorded = record_plans(bench, plans, _plant(bench_data, law), of_law)
        whole = [run for run in recorded.runs if not run.aborted and not run.truncated]
        simulated = {chosen[int(run.plan.run) - 1].run: run for run in whole}
        compared = [run for run in measured if run.plan.run in simulated]
        of_model = [simulated[run.plan.run] for run in compared]
        errors = model_errors(compared, of_model, mass_kg) if compared else {}
        steady = steady_parts(compared, of_model, mass_kg) if compared else None
        stopped = (
            f"the model's board stopped itself after {len(compared)} of {len(measured)} runs: "
            f"{recorded.stopped}"
        )
        why = stopped if recorded.stopped else ""
        verified[law.law] = replace(law, errors=errors, steady=steady, not_verified=why)
        runs_of_law[law.law] = simulated
    followed = tuple(
        Followed(
            run=run.plan.run,
            f_load_n=run.plan.f_load_n,
            p_lr_ref_pa=run.plan.p_lr_ref_pa,
            measured=trace(run, mass_kg),
            modelled={
                law: trace(runs[run.plan.run], mass_kg)
                for law, runs in runs_of_law.items()
                if run.plan.run in runs
            },
            compared_from_s=_compared_from_s(run, mass_kg),
        )
        for run in _first_trials(measured)
    )
    return VerifiedLaws(tuple(verified.get(law.law, law) for law in laws), followed)


def _plant(bench_data: dict[str, Any], law: IdentifiedLaw) -> Plant:
    return parse_plant(merge(bench_data, {"friction": {"test": law.section}}), _EXACT, law.law)


def _with_preceding_runs(plans: Sequence[RunPlan], wanted: set[str]) -> list[RunPlan]:
    chosen: list[RunPlan] = []
    for i, plan in enumerate(plans):
        if plan.run in wanted:
            if i and plans[i - 1].run not in wanted and plans[i - 1].motion is not None:
                chosen.append(plans[i - 1])
            chosen.append(plan)
    return chosen


def _first_trials(runs: Sequence[Run]) -> list[Run]:
    chosen: dict[tuple, Run] = {}
    for run in runs:
        chosen.setdefault(run.plan.operating_point, run)
    return list(chosen.values())


def _compared_from_s(run: Run, mass_kg: float) -> float:
    """Return the time from which errors of a run count; its end if the piston moves too little."""
    counted = run.t_s[logged_motion(run, mass_kg).compared]
    return float(counted[0] if len(counted) else run.t_s[-1])


def trace(run: Run, mass_kg: float) -> Trace:
    """Return velocity and friction of a run, without the ends, where derivatives are one-sided."""
    motion = logged_motion(run, mass_kg)
    kept = motion.centred
    return Trace(run.t_s[kept], motion.v_m_s[kept], motion.friction_n[kept])

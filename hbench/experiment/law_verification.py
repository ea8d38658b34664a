"""Identified laws in a model of the bench that follows the verification profile (section 5.5).

The model is the bench file with the test cylinder's friction replaced, without scatter and
without the sensors' noise, under the firmware in closed loop. It makes the runs that were measured,
and before them the campaign's run before, which leaves bristles and oil as they were.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from hbench.analysis.identification.verification import model_errors
from hbench.analysis.screening.sample_friction import logged_motion
from hbench.config.bench import Plant, merge, parse_bench, parse_plant
from hbench.experiment.closed_loop import record_plans
from hbench.experiment.progress import Progress
from hbench.records import Followed, IdentifiedLaw, Run, RunPlan, Trace

_EXACT = {
    "friction": {"load": {"scatter": "0 %"}},
    "sensors": {"adc": {"noisy": False, "quantised": False}},
}


@dataclass(frozen=True)
class Verified:
    """Laws with their errors, and the curves behind them."""

    laws: tuple[IdentifiedLaw, ...]
    followed: tuple[Followed, ...]


def verify_laws(
    bench_data: dict[str, Any],
    laws: Sequence[IdentifiedLaw],
    measured: Sequence[Run],
    made: Sequence[RunPlan],
    report: Callable[[Progress], None] = lambda progress: None,
) -> Verified:
    """Let each identified law follow the ``measured`` verification runs; compare both.

    ``bench_data`` is the content of the bench file, ``made`` are all runs of the campaign in order.
    The measured ones have their motion and v_ref. A model whose board stops itself is compared as
    far as it came, and the law says so. Raises ``DataError`` for a log without what friction is
    made of.
    """
    bench = parse_bench(bench_data, "bench")
    mass_kg = bench.moving_mass.test
    wanted = {run.plan.run for run in measured}
    chosen = _with_the_run_before(made, wanted)
    plans = [replace(plan, run=f"{i:04d}") for i, plan in enumerate(chosen, 1)]
    tried = [law for law in laws if law.fit is not None]
    done, models = {}, {}
    for before, law in enumerate(tried):

        def over_all(progress: Progress, made: int = before * len(plans)) -> None:
            total = len(tried) * len(plans)
            report(replace(progress, runs_done=made + progress.runs_done, runs_total=total))

        recorded = record_plans(bench, plans, _plant(bench_data, law), over_all)
        whole = [run for run in recorded.runs if not run.aborted and not run.truncated]
        modelled = {chosen[int(run.plan.run) - 1].run: run for run in whole}
        pairs = [(run, modelled[run.plan.run]) for run in measured if run.plan.run in modelled]
        runs, models_runs = [run for run, _ in pairs], [run for _, run in pairs]
        errors = model_errors(runs, models_runs, mass_kg) if pairs else {}
        stopped = (
            f"the model's board stopped itself after {len(pairs)} of {len(measured)} runs: "
            f"{recorded.stopped}"
        )
        why = stopped if recorded.stopped else ""
        done[law.law] = replace(law, errors=errors, not_verified=why)
        models[law.law] = modelled
    followed = tuple(
        Followed(
            run=run.plan.run,
            f_load_n=run.plan.f_load_n,
            p_lr_ref_pa=run.plan.p_lr_ref_pa,
            measured=_trace(run, mass_kg),
            modelled={
                law: _trace(runs[run.plan.run], mass_kg)
                for law, runs in models.items()
                if run.plan.run in runs
            },
        )
        for run in _first_trials(measured)
    )
    return Verified(tuple(done.get(law.law, law) for law in laws), followed)


def _plant(bench_data: dict[str, Any], law: IdentifiedLaw) -> Plant:
    return parse_plant(merge(bench_data, {"friction": {"test": law.section}}), _EXACT, law.law)


def _with_the_run_before(made: Sequence[RunPlan], wanted: set[str]) -> list[RunPlan]:
    chosen: list[RunPlan] = []
    for i, plan in enumerate(made):
        if plan.run in wanted:
            if i and made[i - 1].run not in wanted and made[i - 1].motion is not None:
                chosen.append(made[i - 1])
            chosen.append(plan)
    return chosen


def _first_trials(runs: Sequence[Run]) -> list[Run]:
    chosen: dict[tuple, Run] = {}
    for run in runs:
        plan = run.plan
        key = plan.motion, plan.label, plan.f_load_n, plan.p_lr_ref_pa
        chosen.setdefault(key, run)
    return list(chosen.values())


def _trace(run: Run, mass_kg: float) -> Trace:
    motion = logged_motion(run, mass_kg)
    return Trace(run.t_s, motion.v_m_s, motion.friction_n)

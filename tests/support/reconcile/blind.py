"""The blind benchmark of reconcile: what it says of campaigns with hidden effects.

    python tests/support/reconcile/blind.py OUT all

generates the campaigns of ``hidden`` in ``OUT`` (a process of its own: its laws and plants are
others than the catalogue's and the model's), reconciles each with ``configs/model-aau.yaml``, and
prints the verdicts and the confusion table. What is there already is not made again, and the seeds
of a cell are far apart in the order, so that a part is a sample of the whole. With a third
argument ``imported`` the same logs are imported as those of another bench, and reconciled in that
form.
"""

import json
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path

sys.path.append(str(Path(__file__).parents[3]))  # behind the installed hbench

import numpy as np

from hbench import workflow
from hbench.config.bench import parse_plant
from hbench.config.files.loading import read_yaml
from hbench.config.scaling import scaled
from hbench.model.effects.catalogue import EFFECTS
from hbench.parallel.process_pool import map_on_cores
from hbench.reconcile.diagnose import ReconcileTask, run_search
from hbench.reconcile.estimates import ParameterEstimates, fit_coefficients
from hbench.reconcile.gaps.log_map import expected_square, ranked_gaps, unexplained_gaps
from hbench.reconcile.gaps.model_gaps import expected_variance
from hbench.reconcile.measured.balances import BALANCES
from hbench.reconcile.nuisance import BACKGROUND
from hbench.reconcile.search_result import SearchResult
from hbench.reconcile.verdict import decide_verdict
from hbench.store.campaign.folder import load_campaign
from hbench.workflow.results import calibrated_runs
from tests.support import ROOT
from tests.support.hidden.foreign import write_index
from tests.support.reconcile.coverage import estimated, hidden
from tests.support.shared import once

GENERATE = Path(__file__).parents[1] / "hidden" / "generate.py"
MODEL = ROOT / "configs" / "model-aau.yaml"
BENCH = ROOT / "configs" / "bench-aau.yaml"
CANDIDATES = tuple(name for name in EFFECTS if name not in BACKGROUND)


@dataclass(frozen=True)
class Outcome:
    """What reconcile said of one campaign."""

    name: str
    verdict: str
    named: tuple[str, ...]
    close: tuple[str, ...]  # the ambiguous set
    rest: tuple[str, ...]  # balances that still lack something
    first: tuple[str, float, float, float]  # best candidate: name, score, explained, size
    threshold: float
    before: float  # gaps of held-out points in the balances that the first effect touches
    after: float
    floor: float  # of a correct model whose values are as uncertain
    seconds: float  # of CPU
    coefficients: dict[str, float] = field(default_factory=dict)  # of the first effect, in SI
    learned: tuple[str, ...] = ()  # unnamed laws
    # Of the first effect, if it is named: values and half widths of 95 % intervals, in SI.
    quantities: dict[str, tuple[float, float]] = field(default_factory=dict)


def outcome(
    folder: Path,
    start: Mapping[str, float] | None = None,
    candidates: Sequence[str] = CANDIDATES,
) -> Outcome:
    """Reconcile one campaign, in this process alone; ``start`` are factors on the model."""
    started = time.process_time()
    task = task_of(folder)
    task = replace(task, plant=scaled(task.plant, start or {}))
    measured, found, out = run_search(task, candidates)
    final = found.final.gap_map.in_units_of(found.refitted.gap_map)
    by_effects = found.with_small.gap_map.in_units_of(found.refitted.gap_map)
    left = unexplained_gaps(ranked_gaps(by_effects, np.zeros(len(BALANCES))))
    verdict, _ = decide_verdict(found, left)
    best = found.steps[0].evaluated[0].candidate
    touched = EFFECTS[best.name].balances
    train = np.setdiff1d(np.arange(len(found.final.gap_map.points)), out)
    fit = fit_coefficients(task.plant, found.final, found.names, train)
    return Outcome(
        name=folder.name,
        verdict=verdict,
        named=found.names,
        close=tuple(one.name for one in found.steps[-1].ambiguous),
        rest=tuple(one.name for one in left),
        first=(best.name, best.score, best.explained, best.size),
        threshold=best.threshold,
        before=found.refitted.gap_map.gap(touched, out),
        after=final.gap(touched, out),
        floor=_floor(found, fit, out, touched),
        seconds=time.process_time() - started,
        coefficients=dict(found.final.hypothesis.effects.get(best.name, {})),
        learned=tuple(
            f"{table.adds_to} over {', '.join(table.knots)}"
            for table in found.final.hypothesis.tables
        ),
        quantities=estimated(best.name, fit) if best.name in found.names else {},
    )


def _floor(
    found: SearchResult, fit: ParameterEstimates, out: np.ndarray, touched: Sequence
) -> float:
    """Return the gap that a correct model has on average over balances and operating points."""
    gaps = found.final.gap_map.in_units_of(found.refitted.gap_map)
    expected = expected_square(gaps) + expected_variance(found.final, fit)
    chosen = expected[np.isin(gaps.point, out)][:, np.isin(gaps.names, touched)]
    return float(np.sqrt(np.nanmean(chosen)))


def stored_outcome(folder: Path) -> Outcome:
    """Reconcile a campaign of ``data_samples``, once in a session of tests."""
    return once(f"outcome-{folder.name}", lambda: outcome(folder))


def task_of(folder: Path) -> ReconcileTask:
    """Return the task of a campaign: made by ``hbench run``, or imported, with an unknown board."""
    campaign = load_campaign(folder)
    content = (campaign.header.get("bench") or {}).get("content") or read_yaml(BENCH)
    plant = parse_plant(content, read_yaml(MODEL), MODEL.name)
    runs, instruments = tuple(calibrated_runs(campaign)), campaign.setup().instruments
    return ReconcileTask(
        provenance=campaign.provenance(),
        model=MODEL.name,
        plant_data={},
        bench=campaign.bench(),
        plant=plant,
        runs=runs,
        instruments=instruments,
    )


def outcomes(folder: Path) -> list[Outcome]:
    """Reconcile every campaign of a folder, on all cores; what is known already stays."""
    known = folder / "outcomes.jsonl"
    done = {}
    if known.exists():
        rows = (json.loads(line) for line in known.read_text().splitlines())
        done = {row["name"]: _read(row) for row in rows}
    campaigns = sorted((one.parent for one in folder.glob("[!.]*/campaign.yaml")), key=_turn)
    left = [one for one in campaigns if one.name not in done]
    for one in map_on_cores(outcome, left) if left else ():
        done[one.name] = one
        with known.open("a") as file:
            file.write(json.dumps(asdict(one)) + "\n")
        print(row(one), flush=True)
    return [done[one.name] for one in campaigns if one.name in done]


def _read(row: dict) -> Outcome:
    """Return an outcome from its line, whose lists were tuples."""
    tuples = {key: tuple(value) for key, value in row.items() if isinstance(value, list)}
    return Outcome(**row | tuples)


def _turn(folder: Path) -> tuple[int, str]:
    """Return a campaign's place: a cell's seeds, which follow one another, take turns."""
    return int(folder.name.rpartition("-")[2]) % 4, folder.name


def row(one: Outcome) -> str:
    """Return a line of the listing."""
    name, score, share, size = one.first
    said = "+".join(one.named) or "|".join(one.close) or "-"
    return (
        f"{one.name:44} {one.verdict:9} {said:40} best {name:22} {score:7.1f}/{one.threshold:5.1f} "
        f"{share:5.0%} {size:5.2f}  {one.before:6.2f} -> {one.after:5.2f}  "
        f"rest {','.join(one.rest) or '-'}  learned {'; '.join(one.learned) or '-'}  "
        f"{one.seconds:.0f} s"
    )


def first_said(one: Outcome) -> tuple[str, ...]:
    """Return what stands first: the named effect, or the ambiguous set, or nothing."""
    return one.named[:1] or one.close


def tables(truth: dict, found: list[Outcome]) -> str:
    """Return the confusion table of single effects, and the figures that goals are set for."""
    lines = [
        "",
        f"{'hidden':24} {'size':7} {'right':>6} {'in set':>6} {'wrong':>6} {'unknown':>7} "
        f"{'none':>5}  {'gap before, after (medians)':28} said instead",
    ]
    cells: dict[tuple[str, float], list[Outcome]] = {}
    others: dict[str, list[Outcome]] = {}
    for one in found:
        case = truth[one.name]
        if case["group"] == "single":
            ((name, size),) = case["effects"].items()
            cells.setdefault((name, size), []).append(one)
        else:
            others.setdefault(case["group"], []).append(one)
    for (name, size), own in sorted(cells.items()):
        kinds = [_kind(name, one) for one in own]
        wrong = [
            "|".join(first_said(one))
            for one, kind in zip(own, kinds, strict=True)
            if kind == "wrong"
        ]
        gap = [
            f"{np.median([getattr(one, side) for one in own]):.2f}" for side in ("before", "after")
        ]
        counts = [kinds.count(kind) for kind in ("right", "in set", "wrong", "unknown", "none")]
        lines.append(
            f"{name:24} {size:<7g} {counts[0]:6} {counts[1]:6} {counts[2]:6} {counts[3]:7} "
            f"{counts[4]:5}  {' -> '.join(gap):28} {', '.join(wrong)}"
        )
    for size, word in ((0.5, "mild"), (1.0, "clear"), (2.0, "strong")):
        own = [(name, one) for (name, s), cell in cells.items() if s == size for one in cell]
        if own:
            right = sum(_kind(*each) == "right" for each in own)
            near = sum(_kind(*each) in ("right", "in set") for each in own)
            wrong = sum(_kind(*each) == "wrong" for each in own)
            lines.append(
                f"{word}: {right} of {len(own)} named right first, {near} with the right one in "
                f"the set, {wrong} named or set wrong"
            )
    named = [
        one for (name, _), cell in cells.items() for one in cell if _kind(name, one) == "right"
    ]
    if named:
        near = np.mean([one.after <= 1.3 * one.floor for one in named])
        gone = [1 - (one.after**2 - 1) / (one.before**2 - 1) for one in named if one.before > 1.1]
        extra = sum(len(one.named) > 1 for one in named)
        lines.append(
            f"named right: held-out gap at most 1.3 floors in {near:.0%}; of the gap's excess "
            f"square {np.median(gone):.0%} gone (median); "
            f"{extra} of {len(named)} with a second name"
        )
        lines.append(_coverage(truth, named))
    for group, own in others.items():
        verdicts = {one.verdict: 0 for one in own}
        for one in own:
            verdicts[one.verdict] += 1
        lines.append(f"{group}: {len(own)}, {verdicts}")
        if group == "pair":
            both = sum(set(truth[one.name]["effects"]) <= set(one.named) for one in own)
            lines.append(f"  both named in {both}")
        elif group == "outside":
            flagged = sum(one.verdict != "named" or bool(one.rest) for one in own)
            lines.append(f"  not given a name, or the rest flagged: {flagged}")
    lines.append(f"CPU seconds a campaign: median {np.median([one.seconds for one in found]):.0f}")
    return "\n".join(lines)


def _coverage(truth: dict, named: list[Outcome]) -> str:
    """Return how often the intervals of the effects named right contain what was hidden."""
    inside, errors = [], []
    for one in named:
        ((effect, coefficients),) = truth[one.name]["truth"]["effects"].items()
        for quantity, value in hidden(effect, coefficients).items():
            if value and quantity in one.quantities:
                found, half_width = one.quantities[quantity]
                inside.append(abs(found - value) <= half_width)
                errors.append(abs(found / value - 1))
    if not inside:
        return "no coefficient can be compared"
    return (
        f"95 % intervals of the quantities that were hidden contain the truth in "
        f"{np.mean(inside):.0%} of {len(inside)}; error {np.median(errors):.0%} (median)"
    )


def _kind(name: str, one: Outcome) -> str:
    said = first_said(one)
    if one.named and said == (name,):
        return "right"
    if not said:
        return one.verdict
    return "in set" if name in said and len(said) <= 3 else "wrong"


def imported(campaign: Path) -> None:
    """Import a campaign's logs as those of another bench, beside it; what is there stays."""
    folder = campaign.parent / "imported" / campaign.name
    logs = campaign.parent / "imported" / "logs" / campaign.name
    if not folder.exists():
        write_index(campaign, logs)
        workflow.import_runs(logs, folder, None, lambda: datetime.fromtimestamp(0, UTC))


def main(out: Path, cases: str, form: str = "native") -> None:
    """Generate, reconcile, and print."""
    subprocess.run([sys.executable, GENERATE, out, "--cases", cases], check=True)
    place = out
    if form == "imported":
        place = out / "imported"
        for _ in map_on_cores(imported, [one.parent for one in out.glob("[!.]*/campaign.yaml")]):
            pass
    found = outcomes(place)
    truth = json.loads((out / "truth.json").read_text())
    print()
    for one in found:
        print(row(one))
    print(tables(truth, found))


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])

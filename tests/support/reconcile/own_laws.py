"""Intervals of coefficients where the hidden law is the catalogue's own.

    python tests/support/reconcile/own_laws.py OUT [SEEDS]

hides each effect of the catalogue that acts in the plant, at 0.8 to 2 times its typical size, in
benches of ``hidden``: with unequal valves, errors of the sensors, friction that wanders, ripple.
Each campaign is reconciled. The lines have what is named, and each hidden coefficient beside its
interval. Campaigns in ``OUT`` are not made again.
"""

import json
import subprocess
import sys
from collections.abc import Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import NamedTuple

sys.path.append(str(Path(__file__).parents[3]))  # behind the installed hbench

import numpy as np

from hbench.model.effects.catalogue import EFFECTS, MOVING
from hbench.parallel.process_pool import map_on_cores
from hbench.reconcile.diagnose import run_search
from hbench.reconcile.estimates import fit_coefficients
from hbench.reconcile.hypothesis import effect_coefficients
from tests.support.reconcile.blind import CANDIDATES, GENERATE, task_of

OWN = tuple(
    name
    for name in CANDIDATES
    if EFFECTS[name].balances and not {*EFFECTS[name].laws}.isdisjoint(MOVING)
)
_FIRST_SEED = 7000
_SIZES = (0.8, 2.0)  # typical ones


class Interval(NamedTuple):
    """A hidden coefficient and its estimate, in the catalogue's unit."""

    key: str
    hidden: float
    value: float
    low: float
    high: float

    @property
    def contains(self) -> bool:
        """Whether the 95 % interval contains what was hidden."""
        return self.low <= self.hidden <= self.high

    def __str__(self) -> str:
        mark = "" if self.contains else " MISSED"
        return (
            f"{self.key} {self.value:.4g} ({self.low:.4g} to {self.high:.4g}) for "
            f"{self.hidden:.4g}{mark}"
        )


class OwnOutcome(NamedTuple):
    """What reconcile said of one campaign."""

    name: str
    effect: str
    named: tuple[str, ...]
    intervals: tuple[Interval, ...]  # of the coefficients that were hidden, if it is named

    def __str__(self) -> str:
        said = "+".join(self.named) or "-"
        return f"{self.name:30} {said:30} {'; '.join(map(str, self.intervals))}"


def sections(seeds: int) -> dict[str, dict[str, dict[str, str]]]:
    """Return the section ``effects`` of each campaign, by name."""
    found = {}
    for number, (_, effect) in enumerate(product(range(seeds), OWN), start=_FIRST_SEED):
        rng = np.random.default_rng([number, 24])
        keys = [key for _, key in effect_coefficients(effect)]
        values = {}
        for key in rng.permutation(keys)[: rng.integers(1, len(keys) + 1)].tolist():
            row = EFFECTS[effect].coefficients[key]
            sign = rng.choice([-1, 1]) if row.low < 0 else 1
            values[key] = f"{float(sign * rng.uniform(*_SIZES) * row.typical)!r} {row.unit}"
        found[f"{effect}-{number}"] = {effect: values}
    return found


def outcome(out: Path, item: tuple[str, dict[str, dict[str, str]]]) -> OwnOutcome:
    """Reconcile one campaign, in this process alone."""
    name, section = item
    ((effect, hidden),) = section.items()
    task = task_of(out / name)
    _, found, held_out = run_search(task, CANDIDATES)
    train = np.setdiff1d(np.arange(len(found.final.gap_map.points)), held_out)
    fit = fit_coefficients(task.plant, found.final, found.names, train)
    estimates = fit.of_effect(effect) if effect in found.names else {}
    intervals = [
        Interval(
            key,
            float(text.split()[0]),
            estimates[key].value,
            *(estimates[key].ci95 or (np.nan, np.nan)),
        )
        for key, text in hidden.items()
        if key in estimates
    ]
    return OwnOutcome(name, effect, found.names, tuple(intervals))


def outcomes(out: Path, seeds: int) -> list[OwnOutcome]:
    """Make the campaigns and reconcile them, on all cores.

    One in which the board stopped itself is left out; the generator prints it.
    """
    out.mkdir(parents=True, exist_ok=True)
    wanted = sections(seeds)
    listed = out / "sections.json"
    listed.write_text(json.dumps(wanted, indent=1))
    subprocess.run([sys.executable, GENERATE, out, "--own", listed], check=False)
    made = [(name, section) for name, section in wanted.items() if (out / name).exists()]
    found = []
    for one in map_on_cores(partial(outcome, out), made):
        print(one, flush=True)
        found.append(one)
    return found


def main(arguments: Sequence[str]) -> None:
    """Print the outcomes and their sums."""
    found = outcomes(Path(arguments[0]), int(arguments[1]) if len(arguments) > 1 else 1)
    alone = sum(one.named == (one.effect,) for one in found)
    intervals = [each for one in found for each in one.intervals]
    contained = sum(each.contains for each in intervals)
    errors = [abs(each.value / each.hidden - 1) for each in intervals]
    print(
        f"{alone} of {len(found)} named alone; {contained} of {len(intervals)} intervals contain "
        f"the hidden value; error {np.median(errors):.1%} (median)"
    )


if __name__ == "__main__":
    main(sys.argv[1:])

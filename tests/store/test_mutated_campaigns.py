"""Files that went bad end in a clear error or in flagged runs: no traceback, no wrong number.

Good campaigns and folders of logs are spoilt by seeded mutations (``mutations.py``) and analyzed.
The good files' own results are what the numbers of the spoilt ones are held against.
"""

import math
import re
import resource
import shutil
import signal
import traceback
import warnings
from collections import Counter
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from random import Random

import pytest
import yaml

from hbench import workflow
from hbench.errors import ConfigError, DataError
from hbench.report.campaign.terminal import summary_text
from tests.support.cut_campaign import cut_campaign, two_curves
from tests.support.faults import mutations as m

ROOT = Path(__file__).parents[2]
SAMPLES = ROOT / "data_samples"
HANG_S = 20
SHOWN = 5_000  # files after which a sweep shows its counts, in case it is ended early
MEMORY = 500_000_000  # bytes above what the test itself holds
DYNAMICS = {
    "name": "motions",
    "bench": "bench.yaml",
    "experiments": [
        {
            "kind": "ramp",
            "direction": "extend",
            "speed": "200 mm/s",
            "accelerations": ["0.1 m/s^2"],
        },
        {"kind": "triangle", "speed": "150 mm/s", "cycles": 2},
        {"kind": "steps", "levels": ["50 mm/s", "-50 mm/s"], "dwell": "0.5 s"},
        {"kind": "hold", "positions": ["200 mm"], "duration": "1 s"},
    ],
}


@dataclass(frozen=True)
class Good:
    """A folder whose files are good, and what it gives."""

    folder: Path
    numbers: dict  # what each accepted run gives
    runs: dict[str, bool]  # and whether it is accepted
    notes: tuple[str, ...]


def numbers_of(results) -> dict:
    """Return what runs give, by the runs that it was made of."""
    found = {}
    for one in results.runs:
        if one.accepted and one.means is not None:
            means = one.means
            key = ("run", one.run.plan.run)
            found[key] = (means.v_m_s, means.friction_n, means.f_test_n, means.efficiency or 0.0)
    for curve in results.curves:
        for point in curve.points:
            found[curve.kind, point.runs] = (point.v_m_s, point.friction_n)
    for loop in results.motions.loops:
        found["loop", loop.runs] = (loop.area_j,)
    for level in results.motions.levels:
        found["level", level.number, level.runs] = (level.after_n,)
    for leakage in results.motions.leakages:
        for decay in leakage.decays:
            found["decay", decay.run] = (decay.rate_p_pa_s, decay.rate_r_pa_s)
    return found


def analyzed(folder: Path, *, page: bool = False):
    return (workflow.report if page else workflow.analyze)(folder)


def imported(folder: Path, *, page: bool = False):
    """Bring a folder in and analyze it; ``map.yaml`` beside its logs is its map."""
    out, map_file = folder.parent / "imported", folder / "map.yaml"
    shutil.rmtree(out, ignore_errors=True)
    given = map_file if map_file.exists() else None
    workflow.import_runs(folder, out, given, lambda: datetime(2026, 1, 1, tzinfo=UTC))
    return analyzed(out, page=page)


def good(folder: Path, run=analyzed) -> Good:
    results = run(folder)
    shutil.rmtree(folder / "results", ignore_errors=True)
    accepted = {one.run.plan.run: one.accepted for one in results.runs}
    return Good(folder, numbers_of(results), accepted, notes_of(results))


def notes_of(results) -> tuple[str, ...]:
    """Return what is told of a campaign and of its accepted runs."""
    of_runs = (f"{one.run.plan.run}: {note}" for one in results.runs for note in one.notes)
    return (*results.notes, *of_runs)


@pytest.fixture(scope="session")
def goods(tmp_path_factory, on_the_rig):
    """Return the good folders by name."""
    base = tmp_path_factory.mktemp("good")
    made = {"steady": good(two_curves(base / "steady"))}
    whole = [f"{number:04d}" for number in range(1, 9)]
    made["bad"] = good(cut_campaign(SAMPLES / "bad-runs", base / "bad", whole))
    made["dynamics"] = good(_dynamics(base, on_the_rig))
    workflow.export(base / "steady", base / "csv", "csv")
    made["csv"] = good(base / "csv", imported)
    shutil.copytree(base / "imported", base / "foreign")
    made["foreign"] = good(base / "foreign")
    made["mapped"] = good(_mapped(base), imported)
    return made


def _dynamics(base: Path, on_the_rig) -> Path:
    shared = {"p_lr": "15 bar", "loads": ["500 N"], "hold": "0.3 s", "trials": 1}
    content = {**DYNAMICS, "experiments": []}
    for one in DYNAMICS["experiments"]:
        travel = {} if one["kind"] == "hold" else {"travel": {"start": "100 mm", "end": "250 mm"}}
        content["experiments"].append({**one, **shared, **travel})
    (base / "dynamics.yaml").write_text(yaml.safe_dump(content))
    shutil.copy(ROOT / "configs" / "bench-aau.yaml", base / "bench.yaml")
    on_the_rig(base / "dynamics.yaml", base / "dynamics")
    return base / "dynamics"


def _mapped(base: Path) -> Path:
    """Write logs of another make: strokes to and fro in mm, bar and N, with tabs."""
    folder = base / "mapped"
    folder.mkdir()
    for trial in (1, 2):
        rows, t, x, random = ["ms\tmm\tbar\tN"], 0.0, 0.0, Random(trial)
        for speed in (12.0, -8.0, 12.0, -8.0):
            for _ in range(int(40 / abs(speed) / 0.02)):
                t, x = t + 20, x + 0.02 * speed
                force = 147.3 - math.copysign(6 + 0.1 * abs(speed), speed) + random.gauss(0, 0.2)
                rows.append(f"{t:.1f}\t{x:.3f}\t3.000\t{force:.3f}")
        (folder / f"{trial}_3bar.txt").write_text("\n".join(rows) + "\n")
    columns = {
        "t_s": {"column": "ms", "unit": "ms"},
        "x_m": {"column": "mm", "unit": "mm"},
        "p_tp_pa": {"column": "bar", "unit": "bar"},
        "f_applied_n": {"column": "N", "unit": "N"},
    }
    series = {"label": "NBR", "files": "{trial}_{pressure}bar.txt"}
    series["cylinder"] = {"piston_diameter": "25 mm"}
    rules = {"name": "others", "format": {"separator": "tab"}, "columns": columns}
    rules |= {"constants": {"p_tr_pa": "0 bar"}, "series": [series], "cut": "reversals"}
    (folder / "map.yaml").write_text(yaml.safe_dump(rules | {"min_stroke": "20 mm"}))
    return folder


# class: good folder, files of which one is spoilt, mutations, what analyzes it.
CLASSES = {
    "steady logs": ("steady", "runs/*.dat", m.LOG, analyzed),
    "bad logs": ("bad", "runs/*.dat", m.LOG, analyzed),
    "dynamics logs": ("dynamics", "runs/*.dat", m.LOG, analyzed),
    "steady journal": ("steady", "campaign.yaml", m.JOURNAL, analyzed),
    "bad journal": ("bad", "campaign.yaml", m.JOURNAL, analyzed),
    "dynamics journal": ("dynamics", "campaign.yaml", m.JOURNAL, analyzed),
    "imported logs": ("foreign", "runs/*.csv", m.TABLE, analyzed),
    "imported journal": ("foreign", "campaign.yaml", m.JOURNAL, analyzed),
    "foreign tables": ("csv", "runs/*.csv", m.TABLE, imported),
    "foreign index": ("csv", "runs.csv", m.INDEX, imported),
    "foreign bench": ("csv", "bench.yaml", m.YAML, imported),
    "mapped tables": ("mapped", "*.txt", m.TABS, imported),
    "map": ("mapped", "map.yaml", m.YAML, imported),
}
# What tells nobody that it was changed: foreign files as they come, without a hash.
UNSIGNED = ("foreign tables", "foreign index", "foreign bench", "mapped tables", "map")
# Mutations after which such a file may hold other numbers that nothing speaks against. A file that
# was cut at the end of a line, or has lost the column of a flag, is a whole file as well.
PLAUSIBLE = {"typed", "flipped", "lines_changed", "cell_replaced", "index_cell"}
PLAUSIBLE |= {"truncated", "column_removed"}


class Hangs(BaseException):
    """A mutation takes longer than it may."""


@contextmanager
def limited():
    """Limit time and memory; each warning is an error."""

    def stop(*_):
        raise Hangs(f"more than {HANG_S} s")

    before = resource.getrlimit(resource.RLIMIT_AS)
    held = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    handler = signal.signal(signal.SIGALRM, stop)
    signal.alarm(HANG_S)
    resource.setrlimit(resource.RLIMIT_AS, (held + MEMORY, before[1]))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)
        signal.alarm(0)
        signal.signal(signal.SIGALRM, handler)


def outcome(case: str, clean: Good, folder: Path, run, *, page: bool) -> str:
    """Return how a spoilt folder ends; raise ``AssertionError`` where that is a fault."""
    try:
        with limited():
            results = run(folder, page=page)
            summary_text(results)
    except (ConfigError, DataError) as error:
        named = [path.name for path in folder.rglob("*")] + [folder.name, "imported"]
        assert any(name in error.message for name in named), f"names no file: {error.message}"
        assert len(error.message) < 20_000 and len(error.message.split()) >= 3, error.message
        return "error"
    except (Exception, Hangs) as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        words = f"{type(error).__name__} in {place.filename}:{place.lineno}: {error}"
        raise AssertionError(words) from error
    found = numbers_of(results)
    for key, values in found.items():
        assert all(map(math.isfinite, values)), f"{key} is {values}"
    accepted = {one.run.plan.run: one.accepted for one in results.runs}
    told = set(notes_of(results)) - set(clean.notes)
    other = [
        key
        for key, values in found.items()
        if key not in clean.numbers or not _close(values, clean.numbers[key])
    ]
    # What lacks a run, such as a point of fewer trials, is another one where the run is rejected.
    own = [key for key in other if key in clean.numbers or key[0] == "run"]
    if own and not told:
        assert case in UNSIGNED, f"another number without a word: {own}"
        return "other data"
    lost = set(clean.runs) - set(accepted)
    assert not lost or told or case in UNSIGNED, f"{lost} are gone without a word"
    if any(clean.runs[run] and not accepted[run] for run in clean.runs if run in accepted):
        return "rejected"
    return "told" if told else "same"


def _close(a, b) -> bool:
    return len(a) == len(b) and all(
        math.isclose(x, y, rel_tol=1e-9, abs_tol=1e-12) for x, y in zip(a, b, strict=True)
    )


def sweep(goods: dict[str, Good], base: Path, count: int, seed: int) -> Counter:
    """Spoil ``count`` times; return how many ended how. Raises with all faults."""
    counts, others = Counter(), Counter()
    faults = []
    cases = list(CLASSES.items())
    for number in range(count):
        case, (name, files, mutations, run) = cases[number % len(cases)]
        clean, rng = goods[name], Random(f"{seed} {number}")
        folder = base / "spoilt"
        shutil.copytree(clean.folder, folder, symlinks=True)
        path = rng.choice(sorted(folder.glob(files)))
        mutation = rng.choice(mutations)
        words = f"{number}: {case}: {path.name}: {m.name_of(mutation)}: {mutation(rng, path)}"
        try:
            ending = outcome(case, clean, folder, run, page=number % 50 == 0)
        except AssertionError as error:
            ending = "FAULT"
            faults.append(f"{words}\n    {str(error)[:600]}")
        if mutation is m.unit_replaced and ending != "error":
            ending = "FAULT"
            faults.append(f"{words}\n    a wrong unit is no error")
        if ending == "other data":
            others[m.name_of(mutation)] += 1
        counts[case, ending] += 1
        shutil.rmtree(folder)
        shutil.rmtree(base / "imported", ignore_errors=True)
        if number % SHOWN == SHOWN - 1:
            show(counts)
    show(counts)
    print("other data:", dict(others))
    assert not faults, f"{len(faults)} faults of {count}:\n" + "\n".join(faults)
    assert set(others) <= PLAUSIBLE, others
    return counts


def show(counts: Counter) -> None:
    outcomes = sorted({outcome for _, outcome in counts})
    print("\n" + f"{'':18}" + "".join(f"{one:>12}" for one in outcomes))
    for case in CLASSES:
        print(f"{case:18}" + "".join(f"{counts[case, one]:12}" for one in outcomes))
    sums = [sum(n for (_, o), n in counts.items() if o == one) for one in outcomes]
    print(f"{sum(sums):<18}" + "".join(f"{one:12}" for one in sums))


def test_spoilt_files_end_in_an_error_or_a_flag_never_in_a_traceback(goods, tmp_path):
    counts = sweep(goods, tmp_path, 4 * len(CLASSES), seed=1)
    assert {"error", "rejected", "told", "same"} <= {outcome for _, outcome in counts}


def test_nan_or_a_missing_unit_in_any_number_of_a_campaign_is_an_error(goods, tmp_path):
    shutil.copytree(goods["steady"].folder, tmp_path / "spoilt")
    journal_file = tmp_path / "spoilt" / "campaign.yaml"
    text = journal_file.read_text()
    head, _, runs = text.partition("\nruns:\n")
    first = "- run:" + runs.split("- run:")[1]
    cut = yaml.safe_load(f"{head}\nruns:\n{first}")
    numbers = [
        (where, value)
        for where, value in m.leaves(cut)
        if where[0] in ("bench", "schedule", "log", "runs") and not isinstance(value, bool)
        if isinstance(value, int | float) or re.match(r"-?[\d.]+(e-?\d+)? [A-Za-z]", str(value))
    ]
    assert len(numbers) > 120
    for where, value in numbers:
        bad = float("nan") if isinstance(value, int | float) else value.split()[0]
        section = m.parent(cut, where)
        section[where[-1]] = bad
        journal_file.write_text(yaml.dump(cut, Dumper=yaml.CSafeDumper, sort_keys=False))
        with pytest.raises(DataError, match=r"campaign\.yaml"):
            analyzed(tmp_path / "spoilt")
        section[where[-1]] = value


@pytest.mark.slow
def test_thousands_of_spoilt_files_end_in_an_error_or_a_flag(goods, tmp_path):
    sweep(goods, tmp_path, 2_600, seed=2)


@pytest.mark.nightly
def test_twenty_thousand_spoilt_files_end_in_an_error_or_a_flag(goods, tmp_path):
    sweep(goods, tmp_path, 20_000, seed=3)

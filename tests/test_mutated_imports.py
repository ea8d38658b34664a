"""Spoilt and forged files of every format are imported, or refused with their name.

No traceback, no death of this process, no file elsewhere, no campaign that cannot be read.
``pytest -s -m slow tests/test_mutated_imports.py`` spoils 20 000 and prints how they end.
"""

import io
import re
import shutil
import tempfile
import warnings
from collections import Counter
from datetime import UTC, datetime
from pathlib import Path
from random import Random

import numpy as np
import pytest
import yaml

from hbench import workflow
from hbench.errors import ConfigError, DataError
from hbench.store.campaign.folder import load_campaign
from hbench.store.formats import reading
from tests.support.faults import byte_mutations as b
from tests.support.faults import mutations as m

AT = datetime(2026, 1, 1, tzinfo=UTC)
MEMORY = 900_000_000  # bytes of the readers' process and that this one takes more; it has 100 MB
SHOWN = 5_000  # files after which a sweep shows its counts, in case it is ended early
N = 24
T = np.arange(N) / 100
CHANNELS = {"t": T, "x": 1000 * T, "p": 60 + T, "f": np.sin(T)}
RULES = {
    "name": "mutated",
    "columns": {
        "t_s": {"column": "t", "unit": "s"},
        "x_m": {"column": "x", "unit": "mm"},
        "p_tp_pa": {"column": "p", "unit": "bar"},
        "f_applied_n": {"column": "f", "unit": "kN"},
    },
    "series": [{"label": "A", "files": "a", "cylinder": {"piston_diameter": "40 mm"}}],
}


def as_text(file: Path):
    rows = zip(*CHANNELS.values(), strict=True)
    file.write_text("t,x,p,f\n" + "".join(",".join(map(repr, map(float, r))) + "\n" for r in rows))


def as_twincat(file: Path):
    head = "Name,x,\nStarttime of export,133898804820400000,a\n\nName,t,x,p,f\nUnit,s,mm,bar,kN\n\n"
    rows = zip(1000 * T, *CHANNELS.values(), strict=True)
    file.write_text(head + "".join(",".join(map(repr, map(float, r))) + "\n" for r in rows))


def as_mat(file: Path):
    from scipy.io import savemat

    savemat(file, {**CHANNELS, "s": {"note": "x", "c": [1, "a"]}}, oned_as="column")


def as_packed_mat(file: Path):
    from scipy.io import savemat

    savemat(file, CHANNELS, oned_as="column", do_compression=True)


def as_mat73(file: Path):
    import h5py

    with h5py.File(file, "w", userblock_size=512) as content:
        for name, values in CHANNELS.items():
            packed = {"chunks": (1, 8), "compression": "gzip"} if name == "p" else {}
            data = content.create_dataset(name, data=values[None, :], **packed)
            data.attrs["MATLAB_class"] = np.bytes_("double")
    head = b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM"
    file.write_bytes(head + file.read_bytes()[len(head) :])


def as_parquet(file: Path):
    import pandas as pd

    frame = pd.DataFrame(CHANNELS).assign(note="x")
    frame.to_parquet(file, compression=None)


def as_tdms(file: Path):
    from nptdms import ChannelObject, TdmsWriter

    about = {"wf_increment": 0.01, "wf_start_time": np.datetime64("2024-05-01T12:00:00")}
    with TdmsWriter(file) as writer:
        writer.write_segment([ChannelObject("g", n, v, about) for n, v in CHANNELS.items()])


def as_mdf(file: Path):
    from asammdf import MDF, Signal

    with MDF(version="4.10") as mdf:
        mdf.append([Signal(values, T, name=name) for name, values in CHANNELS.items()])
        mdf.save(file, overwrite=True)


def as_packed_mdf(file: Path):
    from asammdf import MDF

    as_mdf(file)
    with MDF(io.BytesIO(file.read_bytes())) as mdf:
        mdf.save(file, overwrite=True, compression=1)


def as_excel(file: Path):
    import openpyxl

    book = openpyxl.Workbook()
    for row in (list(CHANNELS), *zip(*CHANNELS.values(), strict=True)):
        book.active.append([float(v) if not isinstance(v, str) else v for v in row])
    book.save(file)


# Name of the file: what writes it, what spoils it.
SEEDS = {
    "a.csv": (as_text, b.several),
    "twincat.csv": (as_twincat, b.several),
    "a.mat": (as_mat, b.several),
    "packed.mat": (as_packed_mat, b.in_packed_mat),
    "v73.mat": (as_mat73, b.several),
    "a.parquet": (as_parquet, b.several),
    "a.tdms": (as_tdms, b.several),
    "a.mf4": (as_mdf, b.several),
    "packed.mf4": (as_packed_mdf, b.several),
    "a.xlsx": (as_excel, b.in_archive),
}
INDICES = ("runs.parquet", "campaign.mat")


def rewritten(spoil):
    """Make a mutation of bytes one of a file."""
    return lambda rng, path: path.write_bytes(spoil(rng, path.read_bytes()))


def as_map(rng: Random, path: Path):
    rng.choice((*m.YAML, rewritten(b.several)))(rng, path)


SPOILT_BY = {name: rewritten(spoil) for name, (_, spoil) in SEEDS.items()} | {
    "runs.parquet": rewritten(b.several),
    "campaign.mat": rewritten(b.in_packed_mat),
    "map.yaml": as_map,
}


@pytest.fixture(scope="module")
def seeds(tmp_path_factory):
    """Return a folder of logs for each format, each with a map or an index."""
    folder = tmp_path_factory.mktemp("seeds")
    for name, (write, _) in SEEDS.items():
        (folder / name).mkdir()
        write(folder / name / name)
        series = [{**RULES["series"][0], "files": name}]
        (folder / name / "map.yaml").write_text(yaml.safe_dump({**RULES, "series": series}))
    as_index(folder / "campaign", folder)
    return folder


def as_index(campaign: Path, folder: Path):
    """Write exported logs in both binary layouts."""
    given = folder / "a.csv"
    workflow.import_runs(given, campaign, given / "map.yaml", lambda: AT)
    for name, form in zip(INDICES, ("parquet", "mat"), strict=True):
        workflow.export(campaign, folder / name, form)


@pytest.mark.parametrize("name", [*SEEDS, *INDICES])
def test_sound_files_give_the_same_run(seeds, tmp_path, name):
    rules = seeds / name / "map.yaml"
    given = rules if rules.exists() else None
    workflow.import_runs(seeds / name, tmp_path / "out", given, lambda: AT)
    (run,) = load_campaign(tmp_path / "out").runs()
    np.testing.assert_allclose(run.t_s, T, atol=1e-12)
    np.testing.assert_allclose(run.x_m, T, atol=1e-12)
    np.testing.assert_allclose(run.p_tp_pa, (60 + T) * 1e5)
    np.testing.assert_allclose(run.f_applied_n, np.sin(T) * 1e3)


def ending(folder: Path, out: Path) -> str:
    """Import a spoilt folder; return how that ends. Raises ``AssertionError`` for a fault."""
    rules = folder / "map.yaml"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            workflow.import_runs(folder, out, rules if rules.exists() else None, lambda: AT)
    except (ConfigError, DataError) as error:
        assert not out.exists(), "a failed import left something"
        named = (folder.name, *(path.name for path in folder.rglob("*")))
        assert any(name in error.message for name in named), f"names no file: {error.message}"
        assert len(error.message) < 20_000, error.message[:500]
        if "crashed" in error.message or "exit code" in error.message:
            return "died"
        if "takes longer" in error.message:
            return "too long"
        return "barred" if re.search(r": can't be read[^:]*: ", error.message) else "refused"
    except Exception as error:
        raise AssertionError(f"{type(error).__name__}: {error}") from error
    try:
        runs = list(load_campaign(out).runs())
    except DataError as error:
        raise AssertionError(f"the imported campaign can't be read: {error}") from error
    for run in runs:
        assert np.isfinite(run.t_s).all() and np.isfinite(run.x_m).all()
    return "imported"


def sweep(seeds: Path, base: Path, count: int, seed: int, monkeypatch) -> Counter:
    """Spoil ``count`` times; return how many ended how. Raises with all faults."""
    temporary = base / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    reading._process.close()  # so that the next one has this folder
    counts, faults, before = Counter(), [], memory()
    for number in range(count):
        name, rng = list(SPOILT_BY)[number % len(SPOILT_BY)], Random(f"{seed} {number}")
        folder, out = base / "logs", base / "out"
        shutil.copytree(seeds / ("a.csv" if name == "map.yaml" else name), folder)
        if name == "runs.parquet":
            path = rng.choice(sorted(folder.rglob("*.parquet")))
        else:
            path = folder / name
        SPOILT_BY[name](rng, path)
        try:
            counts[name, ending(folder, out)] += 1
        except AssertionError as error:
            counts[name, "FAULT"] += 1
            faults.append(f"{name} {number}: {str(error)[:600]}")
            shutil.copy(path, base.parent / f"fault-{number}-{path.name}")
        extra = {p.name for p in base.iterdir()} - {"logs", "out", "temporary"}
        if extra or (held := memory() - before) > MEMORY:
            faults.append(f"{name} {number}: {extra or f'{held / 1e6:.0f} MB'}")
        shutil.rmtree(folder)
        shutil.rmtree(out, ignore_errors=True)
        if number % SHOWN == SHOWN - 1:
            show(counts)
    reading._process.close()
    show(counts)
    assert not faults, f"{len(faults)} faults of {count}:\n" + "\n".join(faults)
    assert not list(temporary.iterdir()), "temporary files are left"
    return counts


def memory() -> int:
    """Peak of this process's memory and of that of the readers [bytes]."""
    process = reading._process._process
    numbers = ["self"] + ([process.pid] if process is not None else [])
    total = 0
    for number in numbers:
        lines = Path(f"/proc/{number}/status").read_text().splitlines()
        total += sum(1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM"))
    return total


def show(counts: Counter) -> None:
    ends = sorted({end for _, end in counts})
    print("\n" + f"{'':14}" + "".join(f"{end:>10}" for end in ends))
    for name in dict.fromkeys(name for name, _ in counts):
        print(f"{name:14}" + "".join(f"{counts[name, end]:10}" for end in ends))
    sums = [sum(n for (_, e), n in counts.items() if e == end) for end in ends]
    print(f"{sum(sums):<14}" + "".join(f"{one:10}" for one in sums))


def test_spoilt_files_of_every_format_are_imported_or_refused(seeds, tmp_path, monkeypatch):
    counts = sweep(seeds, tmp_path, 5 * len(SPOILT_BY), 1, monkeypatch)
    assert {"imported", "refused", "barred"} <= {end for _, end in counts}


@pytest.mark.slow
def test_twenty_thousand_spoilt_files_are_imported_or_refused(seeds, tmp_path, monkeypatch):
    sweep(seeds, tmp_path, 20_000, 2, monkeypatch)


@pytest.mark.nightly
def test_eighty_thousand_spoilt_files_are_imported_or_refused(seeds, tmp_path, monkeypatch):
    sweep(seeds, tmp_path, 80_000, 3, monkeypatch)

"""The command that writes blind campaigns; see the package's docstring."""

import argparse
import json
import os
import shutil
import sys
from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

sys.path.append(str(Path(__file__).parents[3]))  # behind the installed hbench

from tests.support import ROOT
from tests.support.hidden.cases import Case, cases, small_sample, stored, truth

TABLE = Path(__file__).parent / "laws" / "table.py"
DISCRIMINATE = ROOT / "configs" / "discriminate.yaml"


def main(arguments: Sequence[str] | None = None) -> int:
    """Write campaigns; return 0, or 1 where the board stopped itself in one."""
    parser = argparse.ArgumentParser(description="Write the blind benchmark's campaigns.")
    parser.add_argument("out", type=Path)
    parser.add_argument(
        "--cases", default="small", help="stored, small, all, or a part of their names"
    )
    parser.add_argument(
        "--hide",
        nargs=3,
        action="append",
        metavar=("EFFECT", "SEVERITY", "SEED"),
        help="instead of --cases: a campaign with this effect, OUT/EFFECT-SEVERITY-SEED",
    )
    parser.add_argument(
        "--own",
        type=Path,
        metavar="FILE",
        help="instead of --cases: JSON with a section 'effects' of the catalogue's own laws for "
        "each campaign OUT/NAME-SEED",
    )
    parser.add_argument("--schedule", type=Path, default=DISCRIMINATE)
    parser.add_argument(
        "--csv",
        choices=("index", "map"),
        help="write them as logs of another bench too, to OUT-index or OUT-map; see foreign.py",
    )
    given = parser.parse_args(arguments)
    lists = {"stored": stored, "small": small_sample, "all": cases}
    if given.own:
        listed = tuple(
            Case(name, {}, int(name.rpartition("-")[2]), "own", section)
            for name, section in json.loads(given.own.read_text()).items()
        )
    elif given.hide:
        listed = tuple(
            Case("-".join(hidden), {hidden[0]: float(hidden[1])}, int(hidden[2]), "single")
            for hidden in given.hide
        )
    elif given.cases in lists:
        listed = lists[given.cases]()
    else:
        listed = tuple(case for case in cases() if given.cases in case.name)
    code = write_all(listed, given.schedule, given.out)
    if given.csv:
        write_logs(listed, given.out, given.csv)
    return code


def write_all(listed: Sequence[Case], schedule: Path, out: Path) -> int:
    """Write each case's campaign to ``out/NAME``, and what was put in to ``out/truth.json``.

    A campaign that is there already, whole, stays.
    """
    os.environ["HBENCH_EFFECTS"] = str(TABLE)  # before hbench's model is imported
    from hbench.parallel.process_pool import map_on_cores
    from hbench.workflow import load_experiment
    from tests.support.hidden.measure import compile_for

    out.mkdir(parents=True, exist_ok=True)
    told = {case.name: asdict(case) | {"truth": asdict(truth(case))} for case in listed}
    (out / "truth.json").write_text(json.dumps(told, indent=1))
    missing = [case for case in listed if not (out / case.name).exists()]
    compile_for(missing, load_experiment(schedule, None).bench)
    stopped = 0
    for done, (name, why) in enumerate(map_on_cores(partial(_write, schedule, out), missing), 1):
        stopped += bool(why)
        print(f"{done}/{len(missing)} {name} {why}", flush=True)
    return int(stopped > 0)


def write_logs(listed: Sequence[Case], out: Path, layout: str) -> None:
    """Write the campaigns in ``out`` as logs to ``out-LAYOUT``. Those that exist are kept."""
    from tests.support.hidden.foreign import LAYOUTS

    logs = out.with_name(f"{out.name}-{layout}")
    for case in listed:
        if (out / case.name).exists() and not (logs / case.name).exists():
            part = logs / f".{case.name}.part"
            shutil.rmtree(part, ignore_errors=True)
            LAYOUTS[layout](out / case.name, part)
            part.rename(logs / case.name)


def _write(schedule: Path, out: Path, case: Case) -> tuple[str, str]:
    from hbench.errors import DeviceError
    from hbench.workflow import load_experiment
    from tests.support.hidden.measure import write

    part = out / f".{case.name}.part"
    shutil.rmtree(part, ignore_errors=True)
    try:
        write(case, load_experiment(schedule, None), part)
    except DeviceError as error:
        return case.name, error.message
    part.rename(out / case.name)
    return case.name, ""


if __name__ == "__main__":
    sys.exit(main())

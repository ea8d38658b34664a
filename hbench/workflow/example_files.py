"""Example files for a cylinder of a given size, with gains designed for it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import yaml

from hbench.config.bench import Bench, parse_bench
from hbench.config.files.edited_yaml import with_values
from hbench.config.files.sized_examples import BENCH_FILE, EXAMPLE_BENCH, Size, sized
from hbench.config.schedule import Screening
from hbench.errors import ConvergenceError
from hbench.workflow.controllers import RATIOS

if TYPE_CHECKING:
    from hbench.control.grid import Grid
    from hbench.control.linearisation import OperatingPoint
    from hbench.control.propose import Proposed

# Bandwidth of the slowest loop for the speeds and accelerations of the example: the velocity
# constant K_v of its printed gains. On a ramp of slope a, the velocity lags by a / K_v.
_SLOWEST_RAD_S = 59.9
# Of the rod side's pressure from its steady value, where the steady window starts: in the example's
# friction, 1.5 N/bar of the piston's seal, this is 40 N of about 500 N.
_LEVEL_PA = 25e5
_COMMENT = "computed for this size"
_UNITS = {"velocity": "V/m", "rod_pressure": "V/(Pa s)", "piston_pressure": "V/(Pa s)"}


@dataclass(frozen=True)
class SizedFiles:
    """Example files for a cylinder of a given size, and how their gains were found."""

    files: dict[str, str]  # name: text
    gains: str


def sized_files(examples: Mapping[str, str], size: Size) -> SizedFiles:
    """Return the example files for a cylinder of ``size``.

    The gains are those of ``control/propose.py`` for the bench of the files, with the ratio that
    gives the fastest slowest loop. Speeds and accelerations are lower than in the example where
    that loop is slower. Raises ``ConvergenceError`` where no gains keep their margins.
    """
    from hbench.control.grid import GAIN_MARGIN_DB, PHASE_MARGIN_DEG, grid, operating_point
    from hbench.control.stopping import stopping_time_s
    from hbench.model.build import plant_parameters
    from hbench.model.pressure_level import level_travel

    bench = parse_bench(yaml.safe_load(sized(examples[EXAMPLE_BENCH], size)), BENCH_FILE)
    par = plant_parameters(bench)
    point = operating_point(bench, par, {})
    found = max(_proposed(bench, point, grid(bench, par)), key=_slowest)
    size = replace(size, time=max(1.0, _SLOWEST_RAD_S / _slowest(found)))
    rules = Screening()
    settle_travel = max(rules.settle_travel, level_travel(par, _LEVEL_PA))
    settling = {
        "settle_time": f"{rules.settle_time * size.time:.2g} s",
        "settle_travel": f"{1e3 * settle_travel:.0f} mm",
    }
    computed = _gains(found)
    example = parse_bench(yaml.safe_load(examples[EXAMPLE_BENCH]), EXAMPLE_BENCH)
    of_example_s = stopping_time_s(plant_parameters(example), example.limits)
    longer = stopping_time_s(par, bench.limits) / of_example_s
    if longer > 1.0:
        stopping_s = longer * example.limits.stopping_time
        computed["limits", "stopping_time"] = f"{1e3 * stopping_s:.2g} ms"
    files = {BENCH_FILE: _with_values(sized(examples[EXAMPLE_BENCH], size), computed)}
    for name, text in examples.items():
        if name != EXAMPLE_BENCH:
            text = sized(text, size)
            files[name] = _with_screening(text, settling) if "\nexperiments:" in text else text
    return SizedFiles(
        files,
        f"phase margins of at least {PHASE_MARGIN_DEG:g} degrees and gain margins of at least "
        f"{GAIN_MARGIN_DB:g} dB at {found.points} operating points of the linear model; slowest "
        f"loop {_slowest(found):.2g} rad/s",
    )


def _proposed(bench: Bench, point: "OperatingPoint", grid: "Grid") -> list["Proposed"]:
    """Return the proposal of each ratio; raises ``ConvergenceError`` if none has one."""
    from hbench.control.propose import propose

    found, failure = [], None
    for ratio in RATIOS:
        try:
            found.append(propose(bench, ratio, point, grid))
        except ConvergenceError as error:
            failure = error
    if failure and not found:
        raise ConvergenceError(failure.message, "Give another size.")
    return found


def _slowest(found: "Proposed") -> float:
    return min(found.bandwidths_rad_s)


def _gains(found: "Proposed") -> dict[tuple[str, ...], str]:
    """Return the gains of a bench file by their path."""
    gains: dict[tuple[str, ...], str] = {}
    for (key, unit), (gain, tau) in zip(_UNITS.items(), found.loops, strict=True):
        gains["controllers", key, "gain"] = f"{gain:.4g} {unit}"
        gains["controllers", key, "time_constant"] = f"{1e3 * tau:.4g} ms"
    return gains


def _with_values(bench: str, values: Mapping[tuple[str, ...], str]) -> str:
    """Return the text of a bench file with computed values, by their path."""
    return with_values(bench, lambda path, _: values.get(path), _COMMENT)


def _with_screening(schedule: str, values: Mapping[str, str]) -> str:
    """Return the text of a schedule with values in its section ``screening``."""
    if "\nscreening:\n" not in schedule:
        schedule = schedule.replace("\nexperiments:", "\nscreening:\n\nexperiments:", 1)
    lines = "".join(f"  {key}: {value}\n" for key, value in values.items())
    return schedule.replace("\nscreening:\n", f"\nscreening:\n{lines}", 1)

"""Analysis of a bench's controllers, and proposal of gains."""

from collections.abc import Mapping
from dataclasses import replace
from datetime import date
from functools import partial
from pathlib import Path

from hbench.config.bench import Bench, parse_bench
from hbench.config.files.edited_yaml import with_values
from hbench.config.files.loading import read_text, read_yaml
from hbench.config.files.yaml_text import parse_yaml
from hbench.control.plausibility import implausible
from hbench.errors import ConfigError, ConvergenceError
from hbench.experiment.progress import Report
from hbench.model.build import plant_parameters
from hbench.records import Design, DesignBasis
from hbench.report.design.figures import draw_design
from hbench.report.design.page import design_page
from hbench.report.design.text import design_json, gains_yaml
from hbench.report.render.figures import figure_files
from hbench.store.files.atomic import write_atomic, write_document

RATIOS = (1.7, 1.3, 2.3)  # of neighbouring bandwidths, in the order in which they are tried


def design(
    bench_file: Path,
    *,
    point: Mapping[str, float],
    source: bool,
    ratio: float | None,
    report: Report,
) -> Design:
    """Analyze the controllers of a bench at an operating point, and propose gains.

    ``point`` may contain v_m_s, f_load_n, x_m and p_lr_pa; missing values are the middle of the
    bench's range. Without any, the point with the least margin is taken. With ``source`` the
    source's numbers are compared; without a ``point``, its operating point is taken. ``ratio`` is
    that of neighbouring bandwidths; with it, gains are proposed and checked with the firmware. If
    they fail, ``RATIOS`` are tried until one passes. Raises ``ConfigError``, ``ConvergenceError``.
    """
    from hbench.control.grid import (  # slow import: scipy.signal
        checks_of_points,
        grid,
        operating_point,
        over_points,
        worst_point,
    )
    from hbench.control.loops import design_at
    from hbench.experiment.design_verification import proposal
    from hbench.studies.source_design import OPERATING_POINT, reproduce

    bench = parse_bench(read_yaml(bench_file), str(bench_file))
    control, par = bench.controllers, plant_parameters(bench)
    loops = control.velocity, control.rod_pressure, control.piston_pressure
    nominal = operating_point(bench, par, point)
    gains = [(loop.gain, loop.time_constant) for loop in loops]
    of_bench = grid(bench, par)
    points = of_bench.points
    every = checks_of_points(points, gains)
    shown = nominal
    if not point:
        shown = (
            OPERATING_POINT if source else operating_point(bench, par, worst_point(points, every))
        )
    analyzed = partial(
        design_at,
        bench.name,
        par,
        shown,
        filters_s=(control.velocity_filter, control.pressure_filter),
        reproduced=reproduce(par) if source else (),
    )
    present = over_points(replace(analyzed(gains), basis=_basis(bench, bench_file)), points, every)
    if ratio is None:
        return present
    proposed = proposal(bench, ratio, nominal, of_bench, report)
    others: dict[float, bool] = {}
    for other in RATIOS if not proposed.holds else ():
        if other != ratio and not any(others.values()):
            try:
                others[other] = proposal(bench, other, nominal, of_bench, report).holds
            except ConvergenceError:
                others[other] = False
    proposed = replace(proposed, other_ratios=others)
    proposed = replace(proposed, loops=analyzed(list(proposed.gains.values())).loops)
    return replace(present, proposal=proposed)


def bench_doubts(bench_file: Path) -> tuple[str, ...]:
    """Return what is implausible in a bench file. Raises ``ConfigError``."""
    bench = parse_bench(read_yaml(bench_file), str(bench_file))
    return tuple(f"{bench_file}: {words}" for words in implausible(bench))


def _basis(bench: Bench, file: Path) -> DesignBasis:
    cylinder, limits, feed = bench.test_cylinder, bench.limits, bench.controllers.feedforward
    return DesignBasis(
        day=date.today().isoformat(),
        file=file.name,
        bore_m=cylinder.piston_diameter,
        rod_m=cylinder.rod_diameter,
        stroke_m=cylinder.stroke,
        supply_pa=bench.supply.pressure,
        travel_m=(limits.travel_min, limits.travel_max),
        pressure_max_pa=limits.pressure_max,
        speed_max_m_s=limits.speed_max,
        feedforward=(feed.rod, feed.piston),
        feedforward_enabled=feed.enabled,
    )


def write_gains(bench_file: Path, design: Design) -> None:
    """Write the proposed gains into the bench file; its other lines stay as they are.

    Raises ``ConfigError`` if the proposal fails a check.
    """
    if design.proposal is None or not design.proposal.holds:
        raise ConfigError(
            f"{bench_file}: unchanged, since the proposal fails a check",
            "See the checks that fail in the table, and the verdict for another --ratio.",
        )
    gains = parse_yaml(gains_yaml(design.proposal))["controllers"]

    def proposed(path: tuple[str, ...], value: str) -> str | None:
        section, loop, key = path if len(path) == 3 else ("", "", "")
        return gains.get(loop, {}).get(key) if section == "controllers" else None

    text = read_text(bench_file)
    changed = with_values(text, proposed, "proposed by hbench design")
    write_atomic(bench_file, changed.encode())


def write_design(folder: Path, design: Design) -> None:
    """Write a design's figures, its numbers as JSON and its page."""
    drawings = draw_design(design)
    files = figure_files(drawings)
    files["design.json"] = design_json(design).encode()
    files["design.html"] = design_page(design, drawings).encode()
    write_document(folder, files, "design.json")

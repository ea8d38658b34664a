"""Grid of operating points that the loops must hold: positions, loads, speeds, both directions.

The loads oppose the motion. The rod side's pressures are the source's shares of the supply
(section 5), so that the load cylinder's piston side lies between tank and supply.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from hbench.config.bench import Bench
from hbench.control import sampled
from hbench.control.linearisation import (
    OperatingPoint,
    linear_coefficients,
    state_space,
    steady_point,
)
from hbench.control.loops import LOOPS
from hbench.control.merits import margins
from hbench.control.sampled import Pi, SampledPlant
from hbench.errors import ConfigError
from hbench.model.parameters import PlantParameters
from hbench.model.plant import TICK_S
from hbench.records import Check, Design, MarginRange, PointMargins

PHASE_MARGIN_DEG, GAIN_MARGIN_DB = 45.0, 6.0
# Shares of the travel, of the force that the rod side can bring, of limits.speed_max.
POSITIONS, LOADS, SPEEDS = (0.0, 0.5, 1.0), (0.05, 0.25, 0.45), (0.0125, 0.125, 0.5)
ROD_PRESSURES = {1: 0.1, -1: 0.73}  # by direction, of the supply's; 15 and 110 of 150 bar
_OMEGA = np.geomspace(0.5, 0.9 * np.pi / TICK_S, 700)


@dataclass(frozen=True)
class Condition:
    """Motion under load that the bench has to hold."""

    direction: int  # 1 extends, -1 retracts
    v_m_s: float  # signed
    f_load_n: float  # signed; opposes the motion
    p_lr_pa: float

    def point(self, par: PlantParameters, x_m: float) -> OperatingPoint:
        """Return its steady state at a position. Raises ``ConfigError`` if there is none."""
        return steady_point(par, x_m, self.v_m_s, self.f_load_n, self.p_lr_pa)


@dataclass(frozen=True)
class GridPoint:
    """Point of the grid with its sampled plant and frequency response."""

    where: str
    x_m: float
    condition: Condition
    plant: SampledPlant
    response: np.ndarray  # (n, 3, 3)


@dataclass(frozen=True)
class Grid:
    """Conditions that a bench reaches, at all positions."""

    points: tuple[GridPoint, ...]
    left_out: tuple[str, ...]  # conditions, with the reason


def load_of(bench: Bench, share: float, direction: int) -> float:
    """Return a load that opposes ``direction``: a share of A_r (P_s - P_t) [N]."""
    supply = bench.supply
    return direction * share * bench.test_cylinder.area_rod_m2 * (supply.pressure - supply.tank)


def conditions(bench: Bench, par: PlantParameters) -> tuple[tuple[Condition, ...], tuple[str, ...]]:
    """Return both directions, all loads and speeds, and why the bench can't reach others."""
    reached, left_out = [], []
    for direction, share in ROD_PRESSURES.items():
        for load in LOADS:
            for speed in SPEEDS:
                condition = Condition(
                    direction,
                    direction * speed * bench.limits.speed_max,
                    load_of(bench, load, direction),
                    share * bench.supply.pressure,
                )
                lowest, highest = bench.sensors.force_range_n
                if not lowest < condition.f_load_n < highest:
                    left_out.append(
                        f"at {1e3 * condition.v_m_s:g} mm/s, load {condition.f_load_n:.4g} N "
                        f"the load cell is at its limit, {lowest:.0f} to {highest:.0f} N"
                    )
                    continue
                try:
                    condition.point(par, bench.limits.travel_min)
                    reached.append(condition)
                except ConfigError as error:
                    left_out.append(error.message)
    return tuple(reached), tuple(left_out)


def operating_point(
    bench: Bench, par: PlantParameters, given: Mapping[str, float]
) -> OperatingPoint:
    """Return the steady point at the ``given`` v_m_s, f_load_n, x_m and p_lr_pa.

    Values not given are those of the middle of the grid, extending. Raises ``ConfigError``.
    """
    limits = bench.limits
    v = given.get("v_m_s", SPEEDS[1] * limits.speed_max)
    x = given.get("x_m", 0.5 * (limits.travel_min + limits.travel_max))
    if v == 0.0:
        raise ConfigError("v = 0: a valve at rest has no operating point", "Give a velocity.")
    if not limits.travel_min <= x <= limits.travel_max:
        raise ConfigError(
            f"x = {1e3 * x:.4g} mm is outside limits.travel "
            f"({1e3 * limits.travel_min:.4g} to {1e3 * limits.travel_max:.4g} mm)"
        )
    direction = 1 if v > 0 else -1
    load = given.get("f_load_n", load_of(bench, LOADS[1], direction))
    p_lr = given.get("p_lr_pa", ROD_PRESSURES[direction] * bench.supply.pressure)
    return steady_point(par, x, v, load, p_lr)


def grid(bench: Bench, par: PlantParameters) -> Grid:
    """Return the points at which margins are computed. They do not depend on the gains."""
    limits, control = bench.limits, bench.controllers
    reached, left_out = conditions(bench, par)
    points = []
    for condition in reached:
        for share in POSITIONS:
            x = limits.travel_min + share * (limits.travel_max - limits.travel_min)
            matrices = state_space(linear_coefficients(par, condition.point(par, x)), par)
            plant = sampled.sample_plant(
                *matrices, control.velocity_filter, control.pressure_filter
            )
            where = f"position {1e3 * x:.0f} mm, speed {1e3 * condition.v_m_s:+.0f} mm/s, "
            where += f"load {condition.f_load_n:+.0f} N"
            response = sampled.measurement_response(plant, _OMEGA)
            points.append(GridPoint(where, x, condition, plant, response))
    return Grid(tuple(points), left_out)


def _point_checks(design: Design) -> tuple[Check, ...]:
    """Check the margins of a design's loops on the board at its operating point."""
    checks = []
    for loop in design.loops:
        board = loop.merits[-1]
        phase, gain = board.phase_margin_deg, 20 * np.log10(board.gain_margin)
        checks += [
            Check(f"{loop.name}: {what}", float(value), limit, unit, bool(value >= limit))
            for what, value, limit, unit in (
                ("phase margin", phase, PHASE_MARGIN_DEG, "deg"),
                ("gain margin", gain, GAIN_MARGIN_DB, "dB"),
            )
        ]
    modulus = design.coupled_modulus
    return (*checks, Check("largest modulus of a digital pole", modulus, 1.0, "1", modulus < 1.0))


def checks_of_points(
    points: Sequence[GridPoint], loops: Sequence[Pi]
) -> tuple[tuple[Check, ...], ...]:
    """Return the checks of the loops at each point."""
    return tuple(margin_checks([point], loops) for point in points)


def worst_point(
    points: Sequence[GridPoint], every: Sequence[Sequence[Check]]
) -> Mapping[str, float]:
    """Return v_m_s, f_load_n, x_m and p_lr_pa of the point with the least margin.

    ``every`` are the checks of each point. Margins count as multiples of their limits, and a point
    where the loops are unstable comes first.
    """

    def least(checks: Sequence[Check]) -> tuple[bool, float]:
        margins = [check.value / check.limit for check in checks if check.unit in ("deg", "dB")]
        return all(check.holds for check in checks if check.unit == "1"), min(margins)

    worst, _ = min(zip(points, every, strict=True), key=lambda pair: least(pair[1]))
    condition = worst.condition
    return {
        "v_m_s": condition.v_m_s,
        "f_load_n": condition.f_load_n,
        "x_m": worst.x_m,
        "p_lr_pa": condition.p_lr_pa,
    }


def over_points(
    design: Design, points: Sequence[GridPoint], every: Sequence[Sequence[Check]]
) -> Design:
    """Return a design with the checks at its operating point, and ``every`` of those of points."""
    held = [all(check.holds for check in checks) for checks in every]
    return replace(
        design,
        checks=_point_checks(design),
        margin_ranges=_margin_ranges(every),
        points=len(points),
        points_failed=held.count(False),
        grid=tuple(
            PointMargins(
                point.x_m,
                point.condition.v_m_s,
                point.condition.f_load_n,
                {check.what: check.value for check in checks if check.unit in ("deg", "dB")},
                holds,
            )
            for point, checks, holds in zip(points, every, held, strict=True)
        ),
    )


def _margin_ranges(every: Sequence[Sequence[Check]]) -> dict[str, MarginRange]:
    """Return the smallest and the largest margin of each loop over all points, by its check."""
    values: dict[str, list[tuple[float, str]]] = {}
    for check in chain.from_iterable(every):
        if check.unit in ("deg", "dB"):
            values.setdefault(check.what, []).append((check.value, check.where))
    return {
        what: MarginRange(min(each)[0], max(each)[0], min(each)[1]) for what, each in values.items()
    }


def margin_checks(points: Sequence[GridPoint], loops: Sequence[Pi]) -> tuple[Check, ...]:
    """Check the margins of all loops at all points: a check per loop and margin, at the worst."""
    phase: dict[str, dict[str, float]] = {}
    gain: dict[str, dict[str, float]] = {}
    moduli: dict[str, float] = {}
    for point in points:
        moduli[point.where] = sampled.modulus(point.plant, loops)
        for i, (name, *_) in enumerate(LOOPS):
            margin = margins(_OMEGA, sampled.broken_loop(point.response, _OMEGA, loops, i))
            phase.setdefault(name, {})[point.where] = margin.phase_deg
            gain.setdefault(name, {})[point.where] = margin.gain_db
    checks = []
    for margin_name, limit, unit, by_loop in (
        ("phase margin", PHASE_MARGIN_DEG, "deg", phase),
        ("gain margin", GAIN_MARGIN_DB, "dB", gain),
    ):
        for name, values in by_loop.items():
            where, value = min(values.items(), key=lambda item: item[1])
            checks.append(
                Check(f"{name}: {margin_name}", value, limit, unit, value >= limit, where)
            )
    where, worst = max(moduli.items(), key=lambda item: item[1])
    checks.append(Check("largest modulus of a digital pole", worst, 1.0, "1", worst < 1.0, where))
    return tuple(checks)

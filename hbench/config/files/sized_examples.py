"""The example files for a cylinder of another size.

The example bench is scaled so that it behaves alike. Up to the example's stroke, lengths and speeds
are in proportion to the stroke, and times do not change. Beyond it, speeds and dead volumes are
those of the example. The valves give the same speed per volt, pressures and bulk modulus are in
proportion to the supply, friction to the length of the seals, loads to the driven area and the
supply. Where the loops of the bench are slower than those of the example, by the factor ``time``,
accelerations are lower by its square: then speed and load pressures lag as in the example.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from hbench.config.files.edited_yaml import Path, with_values
from hbench.units import from_si, to_si

BENCH_FILE = "bench.yaml"  # of another size
EXAMPLE_BENCH = "bench-aau.yaml"
_BORE_M, _ROD_M, _STROKE_M, _SUPPLY_PA = 0.040, 0.025, 0.400, 150e5  # of the example bench
_SPANS_PA = (100e5, 160e5, 250e5, 400e5, 600e5, 1000e5)  # of pressure transducers
_SPAN_OVER_SUPPLY = 250 / 150
_LEAST_PISTON_BAR = 3.0  # that p_lr alone causes in P_Lp, above the tank's pressure
_HIGHEST_ROD = 140 / 150  # of the supply: highest p_lr of the examples
_LEAST_P_LP_PA = 5.5e5  # that the largest retracting load leaves
# Of the example's two cylinders: static friction, sliding friction at 200 mm/s, and friction of the
# seals at the supply pressure.
_STATIC_N, _COULOMB_N, _VISCOUS_N, _SEALS_N = 710.0, 260.0, 1100.0, 450.0
_DRIVING = 0.7  # of the supply, on the rod side; the valve needs the rest
_PUSHED = 0.3  # of the stroke: largest travel of a push, which begins in the middle
_RETRACTING_N = 5000.0  # largest load of the example's moving runs
_FEW_CYCLES, _WARM_UP_CYCLES = 20, 60
_NUMBER = re.compile(r"([-+]?[\d.]+(?:[eE][-+]?\d+)?)( .+)")
_SCALED = "scaled from the example: enter your bench's"
_HEAD = """\
# Bench with a {words}.
#
# Diameters, stroke and supply pressure are those that were given to `hbench init`. Every line that
# says "scaled" is a guess by size from the bench of Aalborg University (`hbench init` without
# options): enter the values of your bench. Other values and comments are those of that bench.
#
# Gains are computed for the values below. After changes compute them again, and check them on the
# virtual rig: hbench design bench.yaml --propose --write
"""


@dataclass(frozen=True)
class Size:
    """Size of the cylinder under test and of its supply, in SI."""

    bore_m: float
    rod_m: float
    stroke_m: float
    supply_pa: float
    time: float = 1.0  # time constant of the slowest loop over that of the example, at least 1

    @property
    def piston_area(self) -> float:
        """A_p over that of the example."""
        return (self.bore_m / _BORE_M) ** 2

    @property
    def rod_area(self) -> float:
        """A_r over that of the example."""
        return (self.bore_m**2 - self.rod_m**2) / (_BORE_M**2 - _ROD_M**2)

    @property
    def piston_m2(self) -> float:
        """A_p."""
        return math.pi / 4 * self.bore_m**2

    @property
    def rod_m2(self) -> float:
        """A_r."""
        return self.piston_m2 * self.area_ratio

    @property
    def area_ratio(self) -> float:
        """A_r / A_p."""
        return 1 - (self.rod_m / self.bore_m) ** 2

    @property
    def length(self) -> float:
        """Stroke over that of the example."""
        return self.stroke_m / _STROKE_M

    @property
    def pressure(self) -> float:
        """Supply pressure over that of the example."""
        return self.supply_pa / _SUPPLY_PA

    @property
    def force(self) -> float:
        """Largest force of the piston side over that of the example."""
        return self.piston_area * self.pressure

    @property
    def seal(self) -> float:
        """Length of the piston seal over that of the example."""
        return self.bore_m / _BORE_M

    @property
    def reach(self) -> float:
        """Lengths that grow no further than in the example."""
        return min(1.0, self.length)

    @property
    def speed(self) -> float:
        """Speeds over those of the example."""
        return min(1.0, math.sqrt(self.length * self.reach) / self.time)

    @property
    def acceleration(self) -> float:
        """Accelerations over those of the example."""
        return self.reach / self.time**2

    @property
    def bulk_modulus(self) -> float:
        """Effective bulk modulus over that of the example.

        The supply pressure compresses the oil by the same share of the stroke; from the example's
        stroke on, where speeds no longer grow, by the same length.
        """
        return self.pressure * self.length / self.reach

    @property
    def valve(self) -> float:
        """Flow gain of the valves over that of the example: the same voltage at scaled speeds."""
        return self.piston_area * self.reach / math.sqrt(self.pressure)

    @property
    def friction_n(self) -> float:
        """Largest friction of both cylinders, scaled from the example."""
        sliding = max(_STATIC_N, _COULOMB_N + _VISCOUS_N * self.speed)
        return self.seal * (sliding + _SEALS_N * self.pressure)

    @property
    def breakaway(self) -> float:
        """Static friction at the supply pressure over that of the example."""
        return self.seal * (_STATIC_N + _SEALS_N * self.pressure) / (_STATIC_N + _SEALS_N)

    @property
    def rod_force_n(self) -> float:
        """Force of the supply pressure on the rod side."""
        return self.supply_pa * self.rod_m2

    @property
    def moved_n(self) -> float:
        """Largest load against which the rod side moves the cylinder, with its friction."""
        return _DRIVING * self.rod_force_n - self.friction_n

    @property
    def held_n(self) -> float:
        """Largest retracting load that leaves P_Lp above the tank pressure at the highest p_lr."""
        return _HIGHEST_ROD * self.rod_force_n - _LEAST_P_LP_PA * self.piston_m2

    @property
    def span_pa(self) -> float:
        """Span of the pressure transducers."""
        least = _SPAN_OVER_SUPPLY * self.supply_pa
        return next((span for span in _SPANS_PA if span >= 0.999 * least), least)

    @property
    def words(self) -> str:
        """Name of the cylinder and its supply."""
        bore, rod, stroke = (f"{1e3 * x:.4g}" for x in (self.bore_m, self.rod_m, self.stroke_m))
        supply = f"{from_si(self.supply_pa, 'bar'):.4g} bar"
        return f"cylinder {bore}/{rod}, stroke {stroke} mm, supply {supply}"


Rule = Callable[[str, Size], str]  # from a value of the example to that of a size


def sized(text: str, size: Size) -> str:
    """Return the text of an example file, with its comments, for a cylinder of another size."""
    if text.count("\ntest_cylinder:") == 1 and "\nname:" in text:
        return _sized_bench(text, size)
    rules: dict[str, Rule] = {**_SCHEDULE, "bench": lambda value, size: BENCH_FILE}
    return with_values(text, _by_last_key(rules, size))


def _sized_bench(text: str, size: Size) -> str:
    body = text[text.index("\nname:") + 1 :]
    body = with_values(body, _by_path(_GIVEN, size), "given")
    body = with_values(body, _by_path(_BENCH, size), _SCALED)
    name: dict[Path, Rule] = {("name",): lambda value, size: f"Bench with a {size.words}"}
    return f"{_HEAD.format(words=size.words)}\n" + with_values(body, _by_path(name, size))


def _by_path(rules: dict[Path, Rule], size: Size) -> Callable[[Path, str], str | None]:
    return lambda path, value: rules[path](value, size) if path in rules else None


def _by_last_key(rules: dict[str, Rule], size: Size) -> Callable[[Path, str], str | None]:
    def change(path: Path, value: str) -> str | None:
        key = next(key for key in reversed(path) if not key.isdigit())
        rule = rules.get(f"{path[0]}.{key}", rules.get(key))
        return None if rule is None else rule(value, size)

    return change


def _exactly(unit: str, si: Callable[[Size], float]) -> Rule:
    """Return the rule of a value that the size states."""
    return lambda value, size: f"{from_si(si(size), unit):.5g} {unit}"


def _times(factor: Callable[[Size], float], digits: int = 2, least: float = -math.inf) -> Rule:
    """Return the rule of a value times a factor, rounded to some digits; its unit stays."""

    def scaled(value: str, size: Size) -> str:
        found = _NUMBER.fullmatch(value)
        if found is None:
            return value
        return f"{_rounded(max(float(found[1]) * factor(size), least), digits)}{found[2]}"

    return scaled


def _rounded(value: float, digits: int, rounding: Callable[[float], int] = round) -> str:
    if value == 0:
        return "0"
    step = 10.0 ** (math.floor(math.log10(abs(value))) - digits + 1)
    rounded = rounding(value / step + 1e-9) * step
    power = f"{rounded:.{digits + 2}g}".replace("e-0", "e-").replace("e+0", "e")
    plain = f"{rounded:.9g}"
    return plain if 1 <= abs(rounded) < 1e5 or len(plain) <= len(power) else power


def _load(value: str, size: Size) -> str:
    """Scale a load by the area that drives against it: of the rod side if it is negative.

    Then no more than the cylinders hold, and in proportion to what the rod side moves.
    """
    digits = max(2, len(value.split()[0].replace(".", "").strip("-0")))  # as the example
    if not value.startswith("-"):
        return _times(lambda size: size.force, digits)(value, size)
    number, unit = value[1:].split()
    factor = min(size.rod_area * size.pressure, size.moved_n / _RETRACTING_N)
    least = min(float(number) * factor, size.held_n / to_si(f"1 {unit}", "N"))
    return f"-{_rounded(least, digits, math.floor)} {unit}"


def _rod_pressure(value: str, size: Size) -> str:
    return _times(lambda size: size.pressure, 2, _LEAST_PISTON_BAR / size.area_ratio)(value, size)


def _cycles(value: str, size: Size) -> str:
    """Return a number of cycles whose log is not too large on a long or slow cylinder.

    The largest number of a warm-up takes no more time than in the example, another one no more than
    five times as much. Few cycles stay.
    """
    number = int(value)
    if number < _FEW_CYCLES:
        return value
    times = 1 if number >= _WARM_UP_CYCLES else 5
    return str(max(_FEW_CYCLES // 2, round(number * min(1.0, times * size.speed / size.length))))


def _displacement(value: str, size: Size) -> str:
    """Return the travel of a push, which no size changes, or what the stroke has room for."""
    number, unit = value.split()
    most = _PUSHED * size.stroke_m / to_si(f"1 {unit}", "m")
    return value if float(number) <= most else f"{_rounded(most, 2, math.floor)} {unit}"


def _of_friction(value: str, size: Size) -> str:
    return _SEAL(value, size) if value.endswith(" N") else value


_PISTON = _times(lambda size: size.piston_area, 4)
_PISTON_VOLUME = _times(lambda size: size.piston_area * size.reach, 4)
_ROD_VOLUME = _times(lambda size: size.rod_area * size.reach, 4)
_LOAD_CELL = _times(lambda size: max(size.piston_area, size.rod_area) * size.pressure)
_LENGTH = _times(lambda size: size.length, 3)
_REACH = _times(lambda size: size.reach)
_SPEED = _times(lambda size: size.speed)
_ACCELERATION = _times(lambda size: size.acceleration, 4)
_SEAL = _times(lambda size: size.seal)
_PRESSURE = _times(lambda size: size.pressure)

_CYLINDERS = ("test_cylinder", "load_cylinder")
_GIVEN: dict[Path, Rule] = {
    ("test_cylinder", "piston_diameter"): _exactly("mm", lambda size: size.bore_m),
    ("test_cylinder", "rod_diameter"): _exactly("mm", lambda size: size.rod_m),
    ("test_cylinder", "stroke"): _exactly("mm", lambda size: size.stroke_m),
    ("supply", "pressure"): _exactly("bar", lambda size: size.supply_pa),
}
_SEALS = ("coulomb", "stiction", "viscous", "bristle_stiffness", "piston_seal", "rod_seal")
_BENCH: dict[Path, Rule] = {
    ("load_cylinder", "piston_diameter"): _exactly("mm", lambda size: size.bore_m),
    ("load_cylinder", "rod_diameter"): _exactly("mm", lambda size: size.rod_m),
    ("load_cylinder", "stroke"): _exactly("mm", lambda size: size.stroke_m),
    ("load_cylinder", "offset"): _LENGTH,
    **{(cylinder, "dead_volume_piston"): _PISTON_VOLUME for cylinder in _CYLINDERS},
    **{(cylinder, "dead_volume_rod"): _ROD_VOLUME for cylinder in _CYLINDERS},
    **{("moving_mass", side): _PISTON for side in ("test", "load")},
    ("oil", "bulk_modulus"): _times(lambda size: size.bulk_modulus, 3),
    ("valve", "gain"): _times(lambda size: size.valve, 3),
    **{("friction", side, key): _SEAL for side in ("test", "load") for key in _SEALS},
    ("end_stop", "stiffness"): _PISTON,
    ("end_stop", "damping"): _PISTON,
    ("sensors", "position", "span"): _LENGTH,
    ("sensors", "pressure", "span"): _exactly("bar", lambda size: size.span_pa),
    ("sensors", "load_cell", "area"): _LOAD_CELL,
    ("controllers", "pressure_slew"): _times(lambda size: size.pressure / size.time),
    ("controllers", "return_speed"): _SPEED,
    ("controllers", "acceleration"): _times(lambda size: size.acceleration, 4, 0.01),  # the board
    ("limits", "speed_max"): _REACH,
    ("limits", "speed_error"): _REACH,
    ("limits", "travel_min"): _REACH,
    ("limits", "travel_max"): _times(lambda size: size.length, 3),
    ("limits", "pressure_max"): _exactly("bar", lambda size: 0.92 * size.span_pa),
    ("instruments", "force", "full_scale"): _LOAD_CELL,
    ("instruments", "pressure", "full_scale"): _exactly("bar", lambda size: size.span_pa),
}
_SCHEDULE: dict[str, Rule] = {
    **dict.fromkeys(("loads", "load"), _load),
    "p_lr": _rod_pressure,
    "limits.pressure": _PRESSURE,  # not that of a check, which is the tank's and is not scaled
    **dict.fromkeys(("start", "end", "position", "positions", "rest_travel"), _LENGTH),
    # A rate in proportion to the stiffness of the oil moves the piston as in the example. The rise
    # must overcome friction in both directions, and the lag of the force loop.
    "rate": _times(lambda size: size.force),
    "rise": _times(lambda size: max(size.force, size.breakaway)),
    "displacement": _displacement,
    "cycles": _cycles,
    **dict.fromkeys(("first", "last", "velocities", "speed", "levels", "velocity"), _SPEED),
    **dict.fromkeys(("acceleration", "accelerations"), _ACCELERATION),
    **dict.fromkeys(("min_step", "max_step", "transition"), _SPEED),
    **dict.fromkeys(("min", "max", "tolerance"), _of_friction),  # limits, adaptive speeds
    "piston_diameter": _exactly("mm", lambda size: size.bore_m),  # of import maps
    "rod_diameter": _exactly("mm", lambda size: size.rod_m),
}

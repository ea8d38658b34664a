"""Hysteresis below breakaway (figure 3.10): Leuven remembers its turns, LuGre drifts."""

from math import exp, log, pi

import numpy as np

from hbench.model.parameters import FrictionParameters
from hbench.records import Finding, Panel, Phenomenon
from hbench.studies.phenomena.driven_friction import driven_mass, prescribed_friction
from hbench.studies.phenomena.laws import LEUVEN, LUGRE, line

TURNS_M = (0.0, 0.3e-3, -0.05e-3, 0.25e-3, -0.05e-3, -0.25e-3)  # A B C D C E


def path(turns_m: tuple[float, ...], step_m: float = 1e-7) -> np.ndarray:
    """Return positions along straight ways between the turns, ``step_m`` apart."""
    ways = [
        np.linspace(a, b, round(abs(b - a) / step_m), endpoint=False)
        for a, b in zip(turns_m[:-1], turns_m[1:], strict=True)
    ]
    return np.concatenate([*ways, turns_m[-1:]])


def traced(turns_m: tuple[float, ...], law: FrictionParameters) -> tuple[np.ndarray, np.ndarray]:
    """Return positions [m] in the middle of steps, and friction [N], along a slow path."""
    x, dt = path(turns_m), 1e-3  # 0.1 mm/s
    return 0.5 * (x[1:] + x[:-1]), prescribed_friction(np.diff(x) / dt, dt, law)


def creep(law: FrictionParameters, low_n: float, high_n: float, cycles: int) -> np.ndarray:
    """Return a mass's position [m] at the start of each cycle of a force between two values."""
    per_cycle, dt = 50_000, 2e-5
    swing = 0.5 * (1 - np.cos(2 * pi * np.arange(per_cycle * cycles + 1) / per_cycle))
    first = np.linspace(0.0, low_n, per_cycle, endpoint=False)
    force = np.concatenate([first, low_n + (high_n - low_n) * swing])
    return driven_mass(force, 0.0, 5.0, dt, law).x_m[per_cycle::per_cycle]


def presliding_loops() -> Phenomenon:
    """Show inner loops along a path that turns, and the drift under a swinging force."""
    # Memory alone, without the terms in velocity.
    leuven = LEUVEN._replace(viscous=0.0, coulomb=LEUVEN.stiction)
    stiffness = sum(
        theta / (leuven.presliding * (i + 1) / len(leuven.elements))
        for i, theta in enumerate(leuven.elements)
    )
    lugre = LUGRE._replace(viscous=0.0, coulomb=LUGRE.stiction, bristle_stiffness=stiffness)
    damped = {
        "Leuven": leuven._replace(bristle_damping=2000.0),
        "LuGre": lugre._replace(bristle_damping=2000.0),
    }
    low, high, cycles = 150.0, 350.0, 10
    crept = {name: creep(law, low, high, cycles) for name, law in damped.items()}
    panels, findings = [], []
    for name, law in (("Leuven", leuven), ("LuGre", lugre)):
        x, force = traced(TURNS_M, law)
        legs = np.round(np.abs(np.diff(TURNS_M)) / 1e-7).astype(int).cumsum()
        turns = dict(zip((0, *(legs - 1)[[0, 1, 2, 4]]), "ABCDE", strict=True))
        panels.append(
            Panel(
                name.lower(),
                f"{name}: an inner loop",
                "Position x (mm)",
                "Friction F (N)",
                (line(name, 1e3 * x, force),),
                names=tuple((1e3 * x[i], float(force[i]), at) for i, at in turns.items()),
            )
        )
        gap = float(force[legs[3] - 1] - force[legs[1] - 1])
        findings.append(
            Finding(
                f"{name}: friction back at C less before",
                "N",
                gap,
                0.0 if name == "Leuven" else _lugre_gap(lugre),
                "the loop closes" if name == "Leuven" else "exponentials of 3.8",
            )
        )
        _, direct = traced((*TURNS_M[:3], TURNS_M[-1]), law)
        tail = legs[4] - legs[3]
        off = np.abs(force[-tail:] - direct[-tail:]).max()
        findings.append(
            Finding(
                f"{name}: trace of the loop on the way to E",
                "N",
                float(off),
                0.0 if name == "Leuven" else None,
                "forgotten" if name == "Leuven" else "not forgotten",
            )
        )
    u_1, u_2 = low / lugre.stiction, high / lugre.stiction
    drift = lugre.stiction / stiffness * log((1 - u_1**2) / (1 - u_2**2))
    panels.append(
        Panel(
            "drift",
            "Creep under a swinging force",
            "Cycles of force, 150 to 350 N",
            "Position (µm), from the first cycle",
            tuple(
                line(name, np.arange(cycles + 1), 1e6 * (x - x[0]), True)
                for name, x in crept.items()
            ),
        )
    )
    findings += [
        Finding(
            "LuGre: drift a cycle",
            "µm",
            1e6 * (crept["LuGre"][-1] - crept["LuGre"][2]) / (cycles - 2),
            1e6 * drift,
            "F_s/sigma_0 ln((1 - u_1^2) / (1 - u_2^2)), u = F/F_s",
        ),
        Finding(
            "Leuven: drift a cycle",
            "µm",
            1e6 * (crept["Leuven"][-1] - crept["Leuven"][2]) / (cycles - 2),
            0.0,
            "0 as the exponent n of 3.15 grows; here n = 20",
        ),
    ]
    return Phenomenon(
        name="presliding",
        title="Presliding hysteresis",
        text=(
            "Below breakaway friction is a spring that loses energy. The path turns at B, C, D and "
            "again at C. Leuven's Maxwell-slip elements remember the turns: the inner loop C D C "
            "closes, and on the way to E it is as if it had never been (nonlocal memory). LuGre "
            "has one state, so its inner loop stays open.",
            "Under a force that swings below stiction a mass on LuGre's friction therefore creeps "
            "along by the same way in each cycle. A real contact, and Leuven, come to rest.",
        ),
        panels=tuple(panels),
        findings=tuple(findings),
    )


def _lugre_gap(law: FrictionParameters) -> float:
    """Return LuGre's friction at the second C of ``TURNS_M`` less the first; closed form."""
    u, at = 0.0, []
    for way in np.diff(TURNS_M):
        decay = exp(-abs(way) * law.bristle_stiffness / law.stiction)
        u = np.sign(way) * (1 - (1 - np.sign(way) * u) * decay)
        at.append(law.stiction * u)
    return float(at[3] - at[1])

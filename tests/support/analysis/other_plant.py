"""A plant that is not the shipped bench's, and a schedule to identify its friction."""

from hbench.analysis.screening.sample_friction import logged_motion

# Other friction, oil, masses, valves and noise.
OTHER_PLANT = {
    "oil": {"bulk_modulus": "640 bar"},
    "moving_mass": {"test": "6 kg", "load": "5.5 kg"},
    "valve": {"gain": "7.7e-7 m^2/V", "bandwidth": "95 Hz"},
    "friction": {
        "test": {
            "law": "lugre",
            "coulomb": "310 N",
            "stiction": "480 N",
            "stribeck_velocity": "55 mm/s",
            "viscous": "2350 N s/m",
            "bristle_stiffness": "2.6e5 N/m",
            "bristle_damping": "100 N s/m",
            "piston_seal": "1 N/bar",
            "rod_seal": "0.5 N/bar",
            "scatter": "1.5 %",
        },
        "load": {
            "coulomb": "290 N",
            "stiction": "440 N",
            "stribeck_velocity": "70 mm/s",
            "viscous": "2450 N s/m",
            "bristle_stiffness": "3.5e5 N/m",
            "scatter": "2 %",
        },
    },
    "sensors": {"adc": {"noise": "0.5 mV"}},
}
OTHER_MASS_KG = 6.0  # the test side's, weighed

# Slow and fast reversals under four loads, two trials: for laws with a memory.
_PROFILE = [
    {"velocity": "20 mm/s", "acceleration": "0.05 m/s^2", "duration": "1 s"},
    {"velocity": "-20 mm/s", "acceleration": "0.05 m/s^2", "duration": "1.5 s"},
    {"velocity": "150 mm/s", "acceleration": "0.2 m/s^2", "duration": "1.5 s"},
    {"velocity": "-150 mm/s", "acceleration": "0.4 m/s^2", "duration": "1.8 s"},
]
REVERSALS = [
    {
        "kind": "verification",
        "p_lr": p_lr,
        "loads": loads,
        "trials": 2,
        "hold": "0.3 s",
        "travel": {"start": "60 mm", "end": "330 mm"},
        "profile": _PROFILE,
    }
    for p_lr, loads in (("15 bar", ["500 N", "3000 N", "5000 N"]), ("80 bar", ["-1000 N"]))
]

# A steady curve that equation 3.7 has: no constant part beside the falling one.
PRESSURE_FRICTION = {
    "law": "lugre",
    "coulomb": "0 N",
    "stiction": "300 N",
    "stribeck_velocity": "80 mm/s",
    "viscous": "2350 N s/m",
    "bristle_stiffness": "2.6e5 N/m",
    "piston_seal": "2.5 N/bar",
    "rod_seal": "1 N/bar",
    "scatter": "1.5 %",
}

# Steady runs at six speeds, four loads, both directions: 48 runs.
STEADY = [
    {
        "kind": "steady",
        "direction": direction,
        "p_lr": p_lr,
        "loads": loads,
        "velocities": ["8 mm/s", "20 mm/s", "40 mm/s", "80 mm/s", "130 mm/s", "180 mm/s"],
        "trials": 2,
        "travel": {"start": "40 mm", "end": "340 mm"},
        "acceleration": "1 m/s^2",
        "hold": "0.2 s",
        "window": "0.5 s",
    }
    for direction, p_lr, loads in (
        ("extend", "15 bar", ["1000 N", "5000 N"]),
        ("retract", "110 bar", ["-1000 N", "-5000 N"]),
    )
]

LEUVEN_FRICTION = {
    "law": "leuven",
    "coulomb": "310 N",
    "stiction": "480 N",
    "stribeck_velocity": "55 mm/s",
    "viscous": "2350 N s/m",
    "elements": ["120 N", "80 N", "400 N"],
    "presliding": "2 mm",
    "shape": 1.0,
    "piston_seal": "1 N/bar",
    "rod_seal": "0.5 N/bar",
    "scatter": "1.5 %",
}


def logged_motions(runs, mass_kg):
    """The motions of several runs."""
    return tuple(logged_motion(run, mass_kg) for run in runs)

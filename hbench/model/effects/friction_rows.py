"""Rows of the catalogue for friction, masses and the ends of the stroke."""

from hbench.config.effects import Coefficient
from hbench.model.effects import friction
from hbench.model.effects.rows import FORCES, Effect, Separation

_LINEAR = Coefficient("1", 0, 0.3, 3, 1)  # exponent
_STRIBECK = Coefficient("1", 0, 0, 1)  # share

ROWS = {
    "seal_pressure_friction": Effect(
        description="dry friction grows with the pressures on piston and rod side",
        coefficients={
            **{
                f"{side}_{chamber}": Coefficient("N/bar", 0.5, 0, 1e3)
                for side in ("test", "load")
                for chamber in ("piston", "rod")
            },
            "exponent": _LINEAR,
            "stribeck": _STRIBECK,
        },
        balances=FORCES,
        laws={"friction": friction.seal_pressure_friction},
        law="dry friction grows by k P_0 (P / P_0)^n for the piston side and for the rod side, "
        "k and P of the side, n = exponent (1: in proportion), P_0 = 50 bar, and the share "
        "stribeck follows the Stribeck curve, equal at 50 mm/s",
        signals="Friction rises with the pressure level, also at the same load.",
        confused_with={
            "load_friction": Separation(
                "steady", "one load at two pressures: guides feel the load, seals the pressure"
            ),
            "direction_asymmetry": Separation(
                "steady", "one load at two pressures: an asymmetry does not change with them"
            ),
            "pressure_offset": Separation(
                "steady", "both directions at several loads: friction turns with the direction"
            ),
            "load_cell_gain": Separation(
                "steady", "both directions: friction turns with the direction, a gain does not"
            ),
        },
        inspect="the seals' type and squeeze, and the change of friction with another seal",
        repair="Fit seals of lower squeeze, or keep this friction in the model.",
        source="energised lip seals; section 3.7 of the bench's source for the drop's form",
    ),
    "load_friction": Effect(
        description="dry friction grows with the cylinder's force",
        coefficients={
            "test": Coefficient("%", 2, 0, 100),
            "load": Coefficient("%", 2, 0, 100),
            "exponent": _LINEAR,
            "stribeck": _STRIBECK,
        },
        balances=FORCES,
        laws={"friction": friction.load_friction},
        law="dry friction grows by k F_0 (|F| / F_0)^n, k = test or load, F the pressure force, "
        "n = exponent (1: in proportion), F_0 = 2500 N, and the share stribeck follows the "
        "Stribeck curve, equal at 50 mm/s",
        signals="Friction rises with the load in both directions.",
        confused_with={
            "load_cell_gain": Separation(
                "steady", "both directions: friction turns with the direction, a gain does not"
            ),
            "position_friction": Separation(
                "steady", "one stroke at several loads: the change along the stroke stays the same"
            ),
        },
        inspect="alignment and guide bands, and the change of friction with another seal",
        repair="Realign the cylinders, or replace the guide bands.",
        source="Coulomb friction of guides under side load in proportion to the force",
    ),
    "direction_asymmetry": Effect(
        description="dry friction is larger in one direction",
        coefficients={"test": Coefficient("%", 10, -90, 90), "load": Coefficient("%", 10, -90, 90)},
        balances=FORCES,
        laws={"friction": friction.direction_asymmetry},
        law="dry friction is F (1 + k sign v), k = test or load",
        signals="Friction differs between extending and retracting by a share of itself.",
        confused_with={
            "load_cell_offset": Separation(
                "steady", "several speeds and loads: an offset is the same force at all"
            ),
            "pressure_offset": Separation(
                "check", "the transducers' zeros with the supply off are free of friction"
            ),
        },
        inspect="the lips' orientation and wear, and the change of friction with the cylinder "
        "turned around, or with other seals",
        repair="Replace the seal or the wiper that rubs unequally.",
        source="lip seals with different lips to either side",
    ),
    "friction_lag": Effect(
        description="dry friction follows the speed with a lag",
        coefficients={"time": Coefficient("ms", 60, 0.1, 1e3)},
        balances=FORCES,
        laws={"friction": friction.friction_lag},
        states=1,
        law="dry friction at the speed s, time ds/dt = |v| - s",
        signals="Friction forms a loop over velocity during ramps and triangles.",
        confused_with={
            "presliding": Separation(
                "triangle", "reversals at two rates: a lag is a time, presliding a distance"
            ),
            "added_mass": Separation(
                "triangle", "two accelerations at equal speeds: a mass follows the acceleration"
            ),
        },
        repair="It is a property of lubricated seals and no defect: keep it in the model.",
        source="Hess and Soom, J. Tribology 112 (1990), as a first-order lag",
    ),
    "rest_time": Effect(
        description="dry friction of the test cylinder grows with the time at rest",
        coefficients={
            "growth": Coefficient("N", 20, 0, 1e4),
            "length": Coefficient("mm", 0, 0.01, 100, 10),
        },
        balances=(),
        laws={"friction": friction.rest_time},
        states=1,
        law="dry friction grows by growth log10(1 + theta / 1 s), lost over length of sliding",
        signals="Breakaway rises with the rest before it; nothing in motion.",
        confused_with={
            "presliding": Separation(
                "breakaway", "several times at rest: presliding does not depend on them"
            ),
        },
        repair="It is a property of elastomer seals and no defect: move the cylinder before a "
        "measurement, or state the time at rest.",
        source="ageing law of rate-and-state friction, Dieterich, J. Geophys. Res. 84 (1979)",
    ),
    "presliding": Effect(
        description="a part of the test cylinder's dry friction builds up over a displacement",
        coefficients={
            "force": Coefficient("N", 100, 0, 1e5),
            "length": Coefficient("mm", 0, 0.05, 100, 2),
        },
        balances=("force_test",),
        laws={"friction": friction.presliding},
        states=1,
        deflects=True,
        law="dz/dt = (v - |v| z) / length; force z replaces force sign(v)",
        signals="Friction changes gradually over some millimetres after a reversal.",
        inspect="soft or thick seals that shear before they slide",
        repair="Keep it in the model, or fit a stiffer seal.",
        source="Dahl, Aerospace Corporation TOR-158 (1968)",
    ),
    "position_friction": Effect(
        description="dry friction of the test cylinder depends on the position",
        coefficients={
            "slope": Coefficient("N", 40, -1e5, 1e5),
            "bow": Coefficient("N", 40, -1e5, 1e5),
        },
        balances=("force_test",),
        laws={"friction": friction.position_friction},
        law="dry friction grows by slope s + bow s^2, s = -1 to 1 along the stroke",
        signals="Friction changes along each stroke, in the same places in both directions.",
        confused_with={
            "end_cushion": Separation(
                "steady", "two speeds: a cushion's force grows with speed, and only towards the end"
            ),
        },
        inspect="the bore's diameter and straightness along the stroke, and the rod's",
        repair="Hone or replace the barrel, or avoid the tight part of the stroke.",
        source="seal squeeze in a bore of varying diameter, to second order",
    ),
    "end_cushion": Effect(
        description="trapped oil brakes the test piston near the ends of its stroke",
        coefficients={
            "length": Coefficient("mm", 0, 1, 1e3, 100),
            "damping": Coefficient("N s/m", 10000, 0, 1e6),
        },
        balances=("force_test",),
        laws={"friction": friction.end_cushion},
        law="force damping (1 - d / length) v while the piston nears an end at the distance d",
        signals="The force rises near an end, the more the faster, and only towards it.",
        inspect="the cushion's throttle screw and check valve",
        repair="Open the throttle, or keep the strokes away from the ends.",
        source="laminar gap of a cushion spear",
    ),
    "added_mass": Effect(
        description="more mass moves than in the model",
        coefficients={
            "test": Coefficient("kg", 20, 0, 500),
            "load": Coefficient("kg", 20, 0, 500),
            "lag": Coefficient("ms", 0, 1, 100, 3),
        },
        balances=FORCES,
        laws={"friction": friction.added_mass},
        states=1,
        law="force m dw/dt, lag dw/dt = v - w, m = test or load",
        signals="Forces while the speed changes; nothing at constant speed.",
        inspect="the moving masses by weighing: rod, coupling, load cell and oil columns",
        repair="Enter the weighed masses in the bench file.",
        source="Newton's law, on a mount that yields over the lag",
    ),
}

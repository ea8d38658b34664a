"""Rows of the catalogue for errors of the sensors and of the board."""

from hbench.config.effects import Coefficient
from hbench.model.effects import instruments
from hbench.model.effects.rows import FLOWS, FORCES, Effect, Separation
from hbench.model.sensors import PRESSURES

ROWS = {
    "load_cell_gain": Effect(
        description="the load cell's reading is wrong by a share of the force",
        coefficients={"error": Coefficient("%", 2, -50, 50)},
        balances=FORCES,
        laws={"sensors": instruments.load_cell_gain},
        law="reading = (1 + error) F",
        signals="The force reading is off in proportion to the load, alike in both directions.",
        confused_with={
            "load_cell_offset": Separation(
                "steady", "loads far apart or of both signs: an offset is the same at all"
            ),
            "pressure_gain": Separation(
                "check", "known weights: steady strokes show a wrong gain of either alike"
            ),
        },
        inspect="the load cell with known weights, and the diameter of the piston",
        repair="Calibrate the load cell, and enter its sensitivity in the bench file.",
        source="linear calibration of a force transducer, ISO 376",
    ),
    "load_cell_offset": Effect(
        description="the load cell's reading is wrong by a constant force",
        coefficients={"force": Coefficient("N", 30, -1e5, 1e5)},
        balances=FORCES,
        laws={"sensors": instruments.load_cell_offset},
        law="reading = F + force",
        signals="The force reading is off by the same force at all loads and in both directions.",
        confused_with={
            "pressure_offset": Separation(
                "check", "zeros of both with the supply off and the load cell uncoupled"
            ),
        },
        inspect="the load cell's zero without load",
        repair="Zero the load cell, or enter its offset in the bench file.",
        source="linear calibration of a force transducer, ISO 376",
    ),
    "pressure_offset": Effect(
        description="a transducer's reading is wrong by a constant pressure",
        coefficients={name: Coefficient("bar", 0.5, -20, 20) for name in PRESSURES},
        balances=(*FLOWS, *FORCES, "supply"),
        laws={"sensors": instruments.pressure_offset},
        law="reading = P + p_0, p_0 of each transducer",
        signals="One pressure reading is off by a constant; force balances by that times an area.",
        confused_with={
            "pressure_gain": Separation(
                "steady", "one load at two pressures: an offset is the same at both"
            ),
        },
        inspect="the zero of each pressure transducer in open air",
        repair="Zero that transducer, or enter its offset in the bench file.",
        source="linear calibration of a pressure transducer",
    ),
    "pressure_gain": Effect(
        description="a transducer's reading is wrong by a share of the pressure",
        coefficients={name: Coefficient("%", 1, -20, 20) for name in PRESSURES},
        balances=(*FLOWS, *FORCES, "supply"),
        laws={"sensors": instruments.pressure_gain},
        alone=True,
        law="reading = (1 + e) P, e of each transducer",
        signals="One pressure reading is off in proportion to the pressure, and its flow with it.",
        inspect="the transducer against a reference gauge at two pressures",
        repair="Calibrate the transducer, and enter its sensitivity in the bench file.",
        source="linear calibration of a pressure transducer",
    ),
    "velocity_filter_lag": Effect(
        description="the board's velocity filter is slower than the bench file says",
        coefficients={"time": Coefficient("ms", 2, 0, 50)},
        balances=("kinematics",),
        laws={"board": instruments.slower_filter},
        law="the filter's time constant grows by time",
        signals="The logged velocity lags the logged position while the speed changes.",
        inspect="controllers.velocity_filter of the bench file against the board's firmware",
        repair="Enter the filter that the board has.",
        source="equation D.11 of the bench's source",
    ),
}

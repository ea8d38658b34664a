"""The message dictionary: the only definition of the messages between host and board.

``python -m hbench.protocol.generate`` writes the firmware's part of it to ``firmware/core``:
``dictionary.h``, ``payloads.h`` and ``payloads.c``. The host compares its hash with the board's
when it connects and refuses a board with another dictionary.

All numbers are little-endian. ``f32`` is an IEEE 754 single. ``text16`` is 16 octets of ASCII,
padded with zeros. ``words`` and ``f32s`` are arrays of u16 and f32 up to the end of the payload.
"""

import binascii
from dataclasses import dataclass

PROTOCOL = 1
REPLY = 0x80  # added to the request's type
ERROR = 0xFF  # type of a refusal
MAX_FRAME = 254  # octets before stuffing: sequence, type, payload, CRC
CRC_START = 0xFFFF  # of the CRC-16 (polynomial 0x1021, not reflected)


@dataclass(frozen=True)
class Message:
    """A request and its reply; fields are (name, type)."""

    name: str
    code: int
    request: tuple[tuple[str, str], ...]
    reply: tuple[tuple[str, str], ...]


# A segment of a run: what the valves do, see VALVES.
SEGMENT = (
    ("valves", "u16"),
    ("v_m_s", "f32"),  # target of v_ref, signed; positive extends the test cylinder
    ("a_m_s2", "f32"),  # slope
    ("duration_s", "f32"),  # upper limit
    ("force_rate_n_s", "f32"),  # of F_T while pushing, signed; positive extends
    ("displacement_m", "f32"),  # of the piston, which ends a push
)

# A step: a sequence of segments (one cycle), repeated, at one load. Its trials have the run numbers
# run, run + 1, ...
STEP = (
    ("run", "u16"),
    ("trials", "u16"),
    ("segment", "u16"),  # index of the first segment
    ("segments", "u16"),
    ("cycles", "u16"),  # upper limit
    ("until", "u16"),  # condition that ends the run earlier
    ("within", "f32"),  # relative change from cycle to cycle below which the condition is met
    ("p_lr_ref_pa", "f32"),
    ("p_lp_ref_pa", "f32"),
    ("x_start_m", "f32"),
    ("x_min_m", "f32"),  # a retracting segment ends below it
    ("x_max_m", "f32"),  # an extending segment ends above it
    ("hold_s", "f32"),  # rest at x_start with the load applied
)

# Payload of a refusal, a reply of type ERROR: the request's type, the number in REFUSALS.
ERROR_REPLY = (("request", "u16"), ("refusal", "u16"))

MESSAGES: tuple[Message, ...] = (
    Message(
        "identify",
        0x01,
        (),
        (
            ("protocol", "u16"),
            ("dictionary", "u32"),  # see dictionary_hash
            ("firmware", "text16"),
            ("board", "text16"),
            ("boots", "u16"),  # different after each reset
            ("rate_hz", "u16"),
            ("ring_records", "u16"),
            ("max_steps", "u16"),
            ("max_segments", "u16"),
        ),
    ),
    Message("write_settings", 0x02, (("first", "u16"), ("values", "f32s")), ()),
    # The schedule. The segments are sent before the steps that refer to them.
    Message(
        "write_segment",
        0x03,
        (("index", "u16"), *SEGMENT),  # index 0 clears the whole schedule first
        (),
    ),
    Message(
        "write_step",
        0x04,
        (("index", "u16"), *STEP),  # index 0 clears the steps first
        (),
    ),
    # Refused unless these CRC-16s equal those of the settings and the schedule on the board.
    Message("start", 0x05, (("settings_crc", "u16"), ("steps_crc", "u16")), ()),
    Message("stop", 0x06, (), ()),
    Message("clear_fault", 0x07, (), ()),
    Message(
        "status",
        0x08,
        (),
        (
            ("state", "u16"),
            ("phase", "u16"),
            ("fault", "u16"),
            ("step", "u16"),
            ("cycle", "u16"),
            ("run", "u16"),
            ("runs_done", "u16"),
            ("tick", "u32"),
            ("log_first", "u32"),  # oldest record in the ring
            ("log_next", "u32"),  # number of the next record
            ("x_m", "f32"),
            ("v_m_s", "f32"),
            ("v_ref_m_s", "f32"),
            ("f_applied_n", "f32"),
            ("p_tp_pa", "f32"),
            ("p_tr_pa", "f32"),
            ("p_lp_pa", "f32"),
            ("p_lr_pa", "f32"),
            ("p_s_pa", "f32"),
        ),
    ),
    Message(
        "read_log",
        0x09,
        (("first", "u32"), ("count", "u16")),
        # first is later than requested if records were overwritten
        (("first", "u32"), ("next", "u32"), ("words", "words")),
    ),
)

STATES = ("idle", "running", "done", "fault")
PHASES = ("none", "return", "hold", "accelerate", "steady", "closed", "brake", "push", "vent")
# In a segment. A run that begins by venting begins where the piston is, without return and hold.
VALVES = (
    "controlled",  # v_ref moves to a velocity at a given slope, then stays constant
    "closed",  # all in neutral, no loop is active
    "pushing",  # F_T rises at a given rate instead of the velocity loop, until the piston moves
    "venting",  # with the supply off: opened to either side in turn, which levels the pressures
)
# Of the force between the cylinders.
LOAD_CONTROLS = (
    "pressures",  # of both load chambers; friction of the load cylinder is added to their force
    "load_cell",  # the reference of P_Lp follows the error of the force that the load cell measures
    "friction_law",  # friction of the load cylinder, by its law, is added to the reference of P_Lp
)
CONDITIONS = ("cycles", "friction", "speed_error")  # that end a run; "cycles": none
FAULTS = (
    "none",
    "heartbeat",
    "sensor",  # a converter word outside the sensor's output range
    "travel",  # outside the limits, or unable to stop within them
    "pressure",
    "speed",
    "speed_error",  # too far from the reference for too long
    "overrun",  # of the control interrupt
    "return",  # the start position is not reached in time
    "load",  # the references of the load's pressures are not reached in time
    "stopped",  # by the host, during a schedule
    "supply",  # on while venting
)
REFUSALS = (
    "none",
    "unknown_message",
    "bad_payload",
    "busy",
    "not_ready",
    "settings_differ",
    "steps_differ",
    "fault_latched",
    "out_of_range",
    "reset_needed",  # the numbers of log records are used up
)

# Sensors of loops, limits and status, in the order of the converter words of a tick.
SENSORS = ("x", "p_tp", "p_tr", "p_lp", "p_lr", "p_s", "f_applied")
# The converter words of a tick and of a record. The auxiliary input has the oil's temperature,
# which is only logged, or an accelerometer.
INPUTS = (*SENSORS, "auxiliary")

PRESSURES = tuple(name for name in SENSORS if name.startswith("p_"))
# Settings of the bench that the host uploads, in this order, with the range in which the board
# starts. SI; gains per 1/16 ADC count. The ranges are wider than any bench and exclude wrong units.
# Within them all products are finite, and no step of a ramp is lost in rounding.
SETTING_RANGES: dict[str, tuple[float, float]] = {
    "gain_x": (1e-9, 1e-3),
    **{f"gain_{name}": (1e-3, 1e5) for name in PRESSURES},
    "gain_f_applied": (1e-6, 1e6),
    "offset_x": (-100.0, 100.0),
    **{f"offset_{name}": (-1e9, 1e9) for name in (*PRESSURES, "f_applied")},
    "velocity_gain_v_m": (1e-6, 1e6),
    "velocity_time_constant_s": (0.0, 60.0),
    "force_gain_v_n": (1e-12, 1e3),
    "rod_gain_v_pa_s": (1e-12, 1.0),
    "rod_time_constant_s": (0.0, 60.0),
    "piston_gain_v_pa_s": (1e-12, 1.0),
    "piston_time_constant_s": (0.0, 60.0),
    "velocity_filter_s": (0.0, 60.0),
    "pressure_filter_s": (0.0, 60.0),
    "feedforward_on": (0.0, 1.0),
    "feedforward_rod_v_s_m": (0.0, 1e4),
    "feedforward_piston_v_s_m": (0.0, 1e4),
    "voltage_limit_v": (1e-3, 100.0),  # and at most the DAC's range
    "pressure_slew_pa_s": (1e5, 1e10),
    "return_speed_m_s": (1e-9, 10.0),
    "acceleration_m_s2": (0.01, 100.0),
    "travel_min_m": (0.0, 20.0),
    "travel_max_m": (0.0, 20.0),
    "pressure_max_pa": (1.0, 1e8),
    "speed_max_m_s": (1e-9, 10.0),
    "stopping_time_s": (0.0, 1.0),
    "speed_error_max_m_s": (1e-9, 10.0),
    "speed_error_time_s": (0.0, 60.0),
    "heartbeat_s": (1e-3, 60.0),
    "area_piston_m2": (1e-9, 10.0),
    "area_rod_m2": (1e-9, 10.0),
    "log_divider": (1.0, 65535.0),
    # Of the auxiliary word, gain per 1/16 ADC count; 0: it is not an acceleration.
    "acceleration_gain_m_s2": (-1.0, 1.0),
    "acceleration_offset_m_s2": (-1e4, 1e4),
    "load_control": (0.0, 2.0),  # see LOAD_CONTROLS
    "load_time_constant_s": (0.01, 60.0),  # of the loop around the load cell
    "load_area_piston_m2": (1e-9, 10.0),
    "load_area_rod_m2": (1e-9, 10.0),
    # Friction of the load cylinder, equation 3.2.
    "load_coulomb_n": (0.0, 1e6),
    "load_stiction_n": (0.0, 1e6),
    "load_stribeck_m_s": (1e-6, 10.0),
    "load_viscous_n_s_m": (0.0, 1e7),
}
SETTINGS = tuple(SETTING_RANGES)


@dataclass(frozen=True)
class Word:
    """One 16-bit word of a log record; ``value = scale * word`` in ``unit``."""

    name: str
    signed: bool
    scale: float
    unit: str


# A record: means over the ticks since the record before, except run, index, flags and v_ref.
# Inputs are in 1/16 of an ADC count.
RECORD: tuple[Word, ...] = (
    Word("run", False, 1, "1"),
    Word("index", False, 1, "1"),  # from 0 in each run
    Word("flags", False, 1, "1"),
    *(Word(name, False, 1 / 16, "count") for name in INPUTS),
    Word("v", True, 2e-5, "m/s"),
    Word("u_t", True, 1e-3, "V"),
    Word("u_l1", True, 1e-3, "V"),
    Word("u_l2", True, 1e-3, "V"),
    Word("v_ref", True, 2e-5, "m/s"),
)

# Bits of the record's flags.
RECORD_FLAGS = (
    "at_reference",  # the whole record lies in the steady phase
    "sensor_saturated",  # a converter word was at 0 or full scale during the record
    "valve_saturated",  # a valve command was at the voltage limit during the record
    "last",  # the run's last record
    "settled",  # with "last": the step's condition was met
)


def canonical_text() -> str:
    """Return the text of all definitions that host and board share."""
    lines = [f"protocol {PROTOCOL}", f"frame {REPLY} {ERROR} {MAX_FRAME} {CRC_START}"]
    for message in MESSAGES:
        for side, fields in (("request", message.request), ("reply", message.reply)):
            text = ",".join(f"{name}:{kind}" for name, kind in fields)
            lines.append(f"{message.code} {message.name} {side} {text}")
    tables = {
        "states": STATES,
        "phases": PHASES,
        "valves": VALVES,
        "load_controls": LOAD_CONTROLS,
        "conditions": CONDITIONS,
        "faults": FAULTS,
        "refusals": REFUSALS,
        "inputs": INPUTS,
        "settings": tuple(
            f"{name}:{low:g}:{high:g}" for name, (low, high) in SETTING_RANGES.items()
        ),
        "flags": RECORD_FLAGS,
    }
    lines += [f"{name} {' '.join(table)}" for name, table in tables.items()]
    lines += [f"word {word}" for word in RECORD]
    return "\n".join(lines)


def dictionary_hash() -> int:
    """Return the CRC-32 of the canonical text."""
    return binascii.crc32(canonical_text().encode("ascii"))

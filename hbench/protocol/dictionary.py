"""The message dictionary: the one description of what host and board say to each other.

The C header ``firmware/core/dictionary.h`` is generated from it
(``python -m hbench.protocol.header > firmware/core/dictionary.h``); its hash is compared when
host and board meet, so two versions never talk past each other.

All numbers are little-endian. ``f32`` is an IEEE 754 single. ``text16`` is 16 octets of ASCII,
padded with zeros. A last field ``words`` or ``f32s`` takes the rest of the payload.
"""

import binascii
from dataclasses import dataclass

PROTOCOL = 1
REPLY = 0x80  # added to a request's type in its reply
ERROR = 0xFF  # type of a refusal
MAX_FRAME = 254  # octets before stuffing: sequence, type, payload, CRC
CRC_START = 0xFFFF  # of the CRC-16 (polynomial 0x1021, not reflected)


@dataclass(frozen=True)
class Message:
    """A request and its reply: fields as (name, type)."""

    name: str
    code: int
    request: tuple[tuple[str, str], ...]
    reply: tuple[tuple[str, str], ...]


MESSAGES: tuple[Message, ...] = (
    Message(
        "identify",
        0x01,
        (),
        (
            ("protocol", "u16"),
            ("dictionary", "u32"),  # CRC-32 of this file's canonical text
            ("firmware", "text16"),
            ("board", "text16"),
            ("boots", "u16"),  # differs after a reset
            ("rate_hz", "u16"),
            ("ring_records", "u16"),
            ("max_steps", "u16"),
            ("max_segments", "u16"),
        ),
    ),
    Message("write_settings", 0x02, (("first", "u16"), ("values", "f32s")), ()),
    # The schedule: steps, each of which plays a row of segments. Segments are sent first.
    Message(
        "write_segment",
        0x03,
        (
            ("index", "u16"),  # 0 clears the whole schedule first
            ("valves", "u16"),
            ("v_m_s", "f32"),  # where v_ref goes
            ("a_m_s2", "f32"),  # at this slope
            ("duration_s", "f32"),  # at most
        ),
        (),
    ),
    Message(
        "write_step",
        0x04,
        (
            ("index", "u16"),  # 0 clears the steps first
            ("run", "u16"),  # number of the first trial's run; the others follow
            ("trials", "u16"),
            ("segment", "u16"),  # the first of its row
            ("segments", "u16"),
            ("cycles", "u16"),  # times that the row is played, at most
            ("until", "u16"),  # what must have settled to end earlier
            ("within", "f32"),  # settled: relative change from cycle to cycle
            ("p_lr_ref_pa", "f32"),
            ("p_lp_ref_pa", "f32"),
            ("x_start_m", "f32"),
            ("x_min_m", "f32"),  # a segment ends below it on its way down,
            ("x_max_m", "f32"),  # and above this on its way up
            ("hold_s", "f32"),
        ),
        (),
    ),
    # The CRC-16s of what the board holds must equal the host's, or nothing moves.
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
            ("log_first", "u32"),  # oldest record still held
            ("log_next", "u32"),  # the number that the next record will get
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
        # first is later than asked where records were overwritten
        (("first", "u32"), ("next", "u32"), ("words", "words")),
    ),
)

STATES = ("idle", "running", "done", "fault")
PHASES = ("none", "return", "hold", "accelerate", "steady", "closed", "brake")
VALVES = ("controlled", "closed")  # in a segment
CONDITIONS = ("cycles", "friction", "speed_error")  # that end a step: "cycles" is none
FAULTS = (
    "none",
    "heartbeat",
    "sensor",  # a converter word that the sensor can't give
    "travel",  # left, or about to be left in spite of closed valves
    "pressure",
    "speed",
    "speed_error",  # too far from the reference for too long
    "overrun",  # of the control interrupt
    "return",  # the way back to the start takes far too long
    "stopped",  # by the host, in the middle of a schedule
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
)

# Sensor channels in the order of the converter; also the order of their words in a record.
SENSORS = ("x", "p_tp", "p_tr", "p_lp", "p_lr", "p_s", "f_applied")

# What the host tells the board about the bench, in order. SI; gains per 1/16 ADC count.
SETTINGS: tuple[str, ...] = (
    *(f"gain_{name}" for name in SENSORS),
    *(f"offset_{name}" for name in SENSORS),
    "velocity_gain_v_m",
    "velocity_time_constant_s",
    "rod_gain_v_pa_s",
    "rod_time_constant_s",
    "piston_gain_v_pa_s",
    "piston_time_constant_s",
    "velocity_filter_s",
    "pressure_filter_s",
    "feedforward_on",
    "feedforward_rod_v_s_m",
    "feedforward_piston_v_s_m",
    "voltage_limit_v",
    "pressure_slew_pa_s",
    "return_speed_m_s",
    "acceleration_m_s2",
    "travel_min_m",
    "travel_max_m",
    "pressure_max_pa",
    "speed_max_m_s",
    "stopping_time_s",
    "speed_error_max_m_s",
    "speed_error_time_s",
    "heartbeat_s",
    "area_piston_m2",
    "area_rod_m2",
    "log_divider",
)


@dataclass(frozen=True)
class Word:
    """One 16-bit word of a log record; ``value = scale * word`` in ``unit``."""

    name: str
    signed: bool
    scale: float
    unit: str


# A record: means over the ticks since the last one, but for run, index, flags and v_ref.
# Sensors are in 1/16 of an ADC count.
RECORD: tuple[Word, ...] = (
    Word("run", False, 1, "1"),
    Word("index", False, 1, "1"),  # from 0 in each run
    Word("flags", False, 1, "1"),
    *(Word(name, False, 1 / 16, "count") for name in SENSORS),
    Word("v", True, 2e-5, "m/s"),
    Word("u_t", True, 1e-3, "V"),
    Word("u_l1", True, 1e-3, "V"),
    Word("u_l2", True, 1e-3, "V"),
    Word("v_ref", True, 2e-5, "m/s"),
)

# Bits of the record's flags.
FLAGS = (
    "at_reference",  # the whole record lies in the steady phase
    "sensor_saturated",  # a conversion of it was at 0 or full scale
    "valve_saturated",  # a command of it was at the voltage limit
    "last",  # the run's last record
    "settled",  # on the last record: the step's condition was met
)


def canonical_text() -> str:
    """All that both sides must agree on, as text."""
    lines = [f"protocol {PROTOCOL}", f"frame {REPLY} {ERROR} {MAX_FRAME} {CRC_START}"]
    for message in MESSAGES:
        for side, fields in (("request", message.request), ("reply", message.reply)):
            text = ",".join(f"{name}:{kind}" for name, kind in fields)
            lines.append(f"{message.code} {message.name} {side} {text}")
    tables = {
        "states": STATES,
        "phases": PHASES,
        "valves": VALVES,
        "conditions": CONDITIONS,
        "faults": FAULTS,
        "refusals": REFUSALS,
        "sensors": SENSORS,
        "settings": SETTINGS,
        "flags": FLAGS,
    }
    lines += [f"{name} {' '.join(table)}" for name, table in tables.items()]
    lines += [f"word {word}" for word in RECORD]
    return "\n".join(lines)


def dictionary_hash() -> int:
    """CRC-32 of the canonical text; host and board compare it when they meet."""
    return binascii.crc32(canonical_text().encode("ascii"))

"""The firmware's host library for tests: functions of the core on arrays, and a board."""

import binascii
import ctypes
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest
from cobs import cobs

from hbench.protocol.dictionary import (
    CRC_START,
    ERROR,
    FAULTS,
    MESSAGES,
    RECORD,
    REFUSALS,
    REPLY,
    SENSORS,
    SETTINGS,
    STATES,
)
from hbench.rig import firmware
from tests.support import shared

FIRMWARE = Path(__file__).parents[2] / "firmware"


@pytest.fixture(scope="session")
def build_preset(tmp_path_factory, require_tool):
    """Function that builds a preset of the firmware once, and returns the folder."""
    require_tool("arm-none-eabi-gcc")
    cmake = require_tool("cmake")

    def build(preset):
        folder = tmp_path_factory.mktemp(preset)
        for options in (["--preset", preset, "-B", folder], ["--build", folder]):
            done = subprocess.run([cmake, *options], cwd=FIRMWARE, capture_output=True, text=True)
            assert done.returncode == 0, done.stdout + done.stderr
        return folder

    return lambda preset: shared.once(preset, lambda: build(preset))


@pytest.fixture(scope="session")
def mps2_build(build_preset):
    """Folder of the mps2 port's image."""
    return build_preset("mps2")


@pytest.fixture(scope="session")
def stm32f4_images(build_preset):
    """Folder of the stm32f4 port's images and call graphs."""
    return build_preset("stm32f4")


_f32 = np.ctypeslib.ndpointer(np.float32, flags="C")
_u16 = np.ctypeslib.ndpointer(np.uint16, flags="C")
_float, _u32, _octets = ctypes.c_float, ctypes.c_uint32, ctypes.c_char_p
_PROBES = (
    ("velocity", None, (_float, _float, _f32, _f32, _f32, _u32)),
    ("lowpass", None, (_float, _float, _f32, _f32, _u32)),
    ("mean", _u32, (ctypes.c_uint16, _u16, _u16, _u32)),
    ("pi", None, (*[_float] * 5, _f32, _f32, _f32, _u32)),
    ("crc", ctypes.c_uint16, (_octets, ctypes.c_uint16)),
    ("cobs_encode", ctypes.c_uint16, (_octets, ctypes.c_uint16, _octets)),
    ("cobs_decode", ctypes.c_uint16, (_octets, ctypes.c_uint16, _octets)),
)


class Probes:
    """Functions of the core on arrays."""

    def __init__(self):
        library = firmware.load_library()
        for name, result, arguments in _PROBES:
            function = getattr(library, f"hb_probe_{name}")
            function.restype, function.argtypes = result, arguments
        self._library = library

    def velocity(self, tau_s, period_s, x, a=None):
        v = np.empty_like(x)
        a = np.zeros_like(x) if a is None else a
        self._library.hb_probe_velocity(tau_s, period_s, x, a, v, len(x))
        return v

    def lowpass(self, tau_s, period_s, x):
        y = np.empty_like(x)
        self._library.hb_probe_lowpass(tau_s, period_s, x, y, len(x))
        return y

    def mean(self, divider, words):
        means = np.empty_like(words)
        return means[: self._library.hb_probe_mean(divider, words, means, len(words))]

    def pi(self, gain, time_constant_s, period_s, limit):
        """Return a controller: call it with an array of errors, step after step."""
        state = np.zeros(2, np.float32)

        def run(e):
            u = np.empty_like(e)
            design = (gain, time_constant_s, period_s, -limit, limit)
            self._library.hb_probe_pi(*design, state, e, u, len(e))
            return u

        return run

    def crc(self, data):
        return self._library.hb_probe_crc(data, len(data))

    def cobs_encode(self, data):
        out = ctypes.create_string_buffer(len(data) + len(data) // 254 + 1)
        count = self._library.hb_probe_cobs_encode(data, len(data), out)
        return out.raw[:count]

    def cobs_decode(self, data):
        out = ctypes.create_string_buffer(max(len(data), 1))
        count = self._library.hb_probe_cobs_decode(data, len(data), out)
        return out.raw[:count]


@pytest.fixture(scope="session")
def probes():
    return Probes()


CODES = {message.name: message.code for message in MESSAGES}
T = 1e-4
GAIN = {"x": 7e-6, "f_applied": 1.0} | {name: 400.0 for name in SENSORS if name[0] == "p"}
OFFSET = {"f_applied": -32760.0}
SETTING_VALUES = {
    **{f"gain_{name}": GAIN[name] for name in SENSORS},
    **{f"offset_{name}": OFFSET.get(name, 0.0) for name in SENSORS},
    "velocity_gain_v_m": 800.0,
    "velocity_time_constant_s": 0.06,
    "force_gain_v_n": 1e-3,
    "rod_gain_v_pa_s": 1.25e-5,
    "rod_time_constant_s": 0.33,
    "piston_gain_v_pa_s": 6.5e-5,
    "piston_time_constant_s": 0.25,
    "velocity_filter_s": 2e-3,
    "pressure_filter_s": 5e-4,
    "feedforward_on": 0.0,
    "feedforward_rod_v_s_m": 5.7205,
    "feedforward_piston_v_s_m": 34.0682,
    "voltage_limit_v": 10.0,
    "pressure_slew_pa_s": 1e7,
    "return_speed_m_s": 0.15,
    "acceleration_m_s2": 0.5,
    "travel_min_m": 0.005,
    "travel_max_m": 0.395,
    "pressure_max_pa": 230e5,
    "speed_max_m_s": 0.4,
    "stopping_time_s": 0.01,
    "speed_error_max_m_s": 0.2,
    "speed_error_time_s": 5.0,
    "heartbeat_s": 2.0,
    "area_piston_m2": 1.25664e-3,
    "area_rod_m2": 7.65763e-4,
    "log_divider": 100.0,
    "acceleration_gain_m_s2": 0.0,
    "acceleration_offset_m_s2": 0.0,
    "load_control": 0.0,
    "load_time_constant_s": 0.1,
    "load_area_piston_m2": 1.25664e-3,
    "load_area_rod_m2": 7.65763e-4,
    "load_coulomb_n": 0.0,
    "load_stiction_n": 0.0,
    "load_stribeck_m_s": 1.0,
    "load_viscous_n_s_m": 0.0,
}
SEGMENT = {
    "valves": 0,
    "v_m_s": 0.1,
    "a_m_s2": 1.0,
    "duration_s": 0.4,
    "force_rate_n_s": 0.0,
    "displacement_m": 0.0,
}
STEP = {
    "run": 1,
    "trials": 1,
    "segment": 0,
    "segments": 1,
    "cycles": 1,
    "until": 0,
    "within": 0.0,
    "p_lr_ref_pa": 15e5,
    "p_lp_ref_pa": 40e5,
    "x_start_m": 0.05,
    "x_min_m": 0.05,
    "x_max_m": 0.35,
    "hold_s": 0.05,
}
STATUS = {
    **dict.fromkeys(("state", "phase", "fault", "step", "cycle", "run", "runs_done"), "H"),
    **dict.fromkeys(("tick", "log_first", "log_next"), "I"),
    **dict.fromkeys(("x_m", "v_m_s", "v_ref_m_s", "f_applied_n"), "f"),
    **dict.fromkeys(("p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa", "p_s_pa"), "f"),
}


class Board:
    """A board with requests as octets and sensors that the test sets, without the host's codec."""

    def __init__(self, boots=1, on=None):
        self.firmware = on or firmware.HostFirmware(boots)
        self.sequence = 0
        self.si = {"x": 0.05, "p_tp": 6e6, "p_tr": 3e6, "p_lp": 4e6, "p_lr": 1.5e6, "p_s": 1.5e7}
        self.si["f_applied"] = 500.0
        self.temp_word = 20_000  # of the oil's temperature, which is only logged
        self.raw = {}  # words that replace those of the sensors

    def exchange(self, octets):
        """Send octets; return the frames that come back: (sequence, type, payload)."""
        self.firmware.receive(octets)
        self.firmware.poll()
        frames = []
        for chunk in self.firmware.transmit().split(b"\0")[:-1]:
            body = cobs.decode(chunk)
            assert binascii.crc_hqx(body[:-2], CRC_START) == int.from_bytes(body[-2:], "little")
            frames.append((body[0], body[1], body[2:-2]))
        return frames

    @staticmethod
    def frame(sequence, code, payload=b""):
        body = bytes((sequence, code)) + payload
        body += binascii.crc_hqx(body, CRC_START).to_bytes(2, "little")
        return cobs.encode(body) + b"\0"

    def request(self, name, payload=b"", again=False):
        """Return the reply's payload, or the refusal's name. ``again``: with the last sequence."""
        self.sequence = (self.sequence + (not again)) % 256
        ((sequence, code, reply),) = self.exchange(self.frame(self.sequence, CODES[name], payload))
        assert sequence == self.sequence
        if code == ERROR:
            request, refusal = struct.unpack("<HH", reply)
            assert request == CODES[name]
            return REFUSALS[refusal]
        assert code == CODES[name] | REPLY
        return reply

    def write_settings(self, first=0, **changes):
        values = struct.pack(
            f"<{len(SETTINGS)}f", *({**SETTING_VALUES, **changes}[name] for name in SETTINGS)
        )
        self.settings_crc = binascii.crc_hqx(values, CRC_START)
        return self.request("write_settings", struct.pack("<H", first) + values[4 * first :])

    def write_segment(self, index=0, **changes):
        fields = struct.pack("<H5f", *{**SEGMENT, **changes}.values())
        before = self.segments_octets[: len(fields) * index] if index else b""
        self.segments_octets = before + fields
        return self.request("write_segment", struct.pack("<H", index) + fields)

    def write_step(self, index=0, **changes):
        fields = struct.pack("<6H7f", *{**STEP, **changes}.values())
        before = self.steps_octets[: len(fields) * index] if index else b""
        self.steps_octets = before + fields
        return self.request("write_step", struct.pack("<H", index) + fields)

    def write_motion(self, index=0, **changes):
        """Upload a step of one segment; the changes are fields of either."""
        segment = {key: changes.pop(key) for key in SEGMENT if key in changes}
        assert self.write_segment(index, **segment) == b""
        return self.write_step(index, segment=index, **changes)

    def write_row(self, *segments, **step):
        """Upload one step with a sequence of segments."""
        for index, segment in enumerate(segments):
            assert self.write_segment(index, **segment) == b""
        return self.write_step(segments=len(segments), **step)

    def start(self, again=False):
        steps_crc = binascii.crc_hqx(self.segments_octets + self.steps_octets, CRC_START)
        return self.request("start", struct.pack("<HH", self.settings_crc, steps_crc), again)

    def status(self):
        values = struct.unpack("<" + "".join(STATUS.values()), self.request("status"))
        return dict(zip(STATUS, values, strict=True))

    def cause(self):
        """State and fault, by name."""
        status = self.status()
        return STATES[status["state"]], FAULTS[status["fault"]]

    def read_log(self, first, count=100):
        """Return the first record's number, the next number, and the words."""
        reply = self.request("read_log", struct.pack("<IH", first, count))
        words = np.frombuffer(reply[8:], "<u2").reshape(-1, len(RECORD))
        return *struct.unpack("<II", reply[:8]), words

    def skip_records(self, number):
        """Give the log's next record a number, as after so many records."""
        skip = firmware.load_library().hb_probe_skip_records
        skip.restype, skip.argtypes = None, (ctypes.c_void_p, ctypes.c_uint32)
        skip(self.firmware.addresses[2], number)

    def words(self):
        """Converter words of the present sensor values."""
        words = {n: round((self.si[n] - OFFSET.get(n, 0.0)) / GAIN[n]) for n in SENSORS}
        return list({**words, "auxiliary": self.temp_word, **self.raw}.values())

    def tick(self):
        """One tick with the present sensor values; returns the valve commands in volts."""
        return [code / 204.8 for code in self.firmware.tick(self.words())]

    def rest(self, seconds, x):
        """Rest at x."""
        self.si["x"] = x
        for _ in range(round(seconds / T)):
            self.tick()


@pytest.fixture(scope="module")
def new_board():
    """Function that returns a board after a reset; all are closed after the module.

    ``on`` is firmware that runs elsewhere, to be closed by the caller.
    """
    boards = []

    def make(boots=1, on=None):
        board = Board(boots, on)
        if on is None:
            boards.append(board)
        return board

    yield make
    for board in boards:
        board.firmware.close()


@pytest.fixture
def board(new_board):
    """A board at rest with settings and one step of one segment."""
    board = new_board()
    assert board.write_settings() == b""
    assert board.write_motion() == b""
    board.rest(0.01, x=0.05)
    return board


@pytest.fixture
def moving(board):
    """A board that returns from x = 60 mm to its start, valves open."""
    board.rest(0.05, x=0.06)
    board.start()
    for _ in range(300):
        commands = board.tick()
    assert commands[0] < -0.1
    return board

"""A virtual rig during a run: fault injection and observation, tick by tick, until rest."""

from dataclasses import dataclass

import numpy as np

from hbench.config.bench import parse_bench
from hbench.config.files.loading import read_yaml
from hbench.experiment.plan import load_pressure
from hbench.model.plant import P_LR, P_S, P_TP, TICK_S, V, X
from hbench.model.sensors import SENSORS
from hbench.protocol.codec import BY_NAME, unpack
from hbench.protocol.dictionary import FAULTS, PHASES, STATES
from hbench.protocol.frames import Frame, Receiver, encode
from hbench.rig.board_settings import board_settings
from hbench.rig.client import BoardClient
from hbench.rig.virtual import VirtualRig
from tests.support import ROOT

BENCH_FILE = ROOT / "configs" / "bench-aau.yaml"
BENCH = parse_bench(read_yaml(BENCH_FILE), str(BENCH_FILE))
SETTINGS = board_settings(BENCH)
REST_M_S = 1e-4
LONGEST_TICKS = 5000
AFTERWARDS_TICKS = 2000


@dataclass(frozen=True)
class Stop:
    """Result of an event. Ticks are control ticks of 0.1 ms."""

    fault: str
    detection_ticks: int  # from the event to the fault
    neutral_ticks: int  # from the fault to neutral valves
    v_m_s: float  # at the command to neutral, in the direction of the run
    distance_m: float  # largest afterwards, in the direction of the run
    rest_ticks: int  # from then until rest
    x_m: float  # furthest position
    p_before_pa: np.ndarray  # of the four chambers
    p_highest_pa: np.ndarray  # of the four chambers, from neutral on


class MovingRig(VirtualRig):
    """The sample bench at the speed ``v`` (signed), under a load that opposes or helps it.

    ``vary`` changes the parameters of the plant; ``settings`` replace settings of the board.
    """

    def __init__(self, v, f_load, p_lr, x_at, vary=None, a=1.0, travel=(0.03, 0.35), **settings):
        super().__init__(BENCH)
        if vary:
            self._bench = self._bench._replace(par=vary(self.par))
        self._v = v
        low, high = travel
        row = {"segment": 0, "segments": 1, "cycles": 1, "until": 0, "within": 0.0}
        load = {"p_lr_ref_pa": p_lr, "p_lp_ref_pa": load_pressure(BENCH, f_load, p_lr)}
        where = {"x_start_m": low if v > 0 else high, "x_min_m": low, "x_max_m": high}
        step = {"run": 1, "trials": 1, **row, **load, **where, "hold_s": 0.1}
        segment = {"valves": 0, "v_m_s": v, "a_m_s2": a, "duration_s": 20.0}
        segment |= {"force_rate_n_s": 0.0, "displacement_m": 0.0}
        client = BoardClient(self)
        crc = client.write_settings({**SETTINGS, **settings})
        client.start(crc, client.write_schedule([segment], [step]))
        while True:
            status = client.status()
            assert STATES[status["state"]] == "running", FAULTS[status["fault"]]
            moves = PHASES[status["phase"]] in ("accelerate", "steady")
            if moves and self.along(status["x_m"] - x_at) >= 0:
                break
            client.wait(0.002)

    def along(self, value):
        """Return a distance or speed in the direction of the run."""
        return float(np.copysign(1.0, self._v) * value)

    @property
    def x(self):
        return float(self._bench.state[X])

    @property
    def v(self):
        return float(self._bench.state[V])

    @property
    def par(self):
        return self._bench.par

    @property
    def chambers(self):
        return self._bench.state[P_TP : P_LR + 1].copy()

    def vary(self, **changes):
        """Change parameters of the plant."""
        self._bench = self._bench._replace(par=self.par._replace(**changes))

    def raise_supply(self, pressure_pa):
        """Change the supply pressure."""
        self._bench.state[P_S] = pressure_pa

    def break_sensor(self, name, counts=None):
        """Freeze a channel at ``counts`` or at its present value, with the converter's noise."""
        i = SENSORS.index(name)
        frozen = self._bench.words[i] / 16.0 if counts is None else float(counts)
        sensors = self._bench.sensors
        gains, zeros = list(sensors.per_unit), list(sensors.zero)
        gains[i], zeros[i] = 0.0, frozen
        sensors = sensors._replace(per_unit=tuple(gains), zero=tuple(zeros))
        self._bench = self._bench._replace(sensors=sensors)

    def overrun(self):
        self._board.overrun()

    def tick(self):
        """One control tick; returns the DAC's codes."""
        self.read(TICK_S)
        return self._bench.codes.copy()

    def board_state(self):
        """State and fault of the board, by a request that takes no time; it is a heartbeat."""
        self._board.transmit()
        self._board.receive(encode(Frame(77, BY_NAME["status"].code, b"")))
        self._board.poll()
        (frame,) = Receiver().feed(self._board.transmit())
        status = unpack(BY_NAME["status"].reply, frame.payload)
        return STATES[status["state"]], FAULTS[status["fault"]]

    def stop(self, silent=False):
        """Simulate from an event until some time after the piston is at rest, which is asserted.

        With ``silent`` the host sends nothing, so the tick of the fault is that of the valves.
        """
        detected = None
        for tick in range(1, LONGEST_TICKS):
            before, x, v = self.chambers, self.x, self.along(self.v)
            neutral = not np.any(self.tick())
            if not silent and detected is None and self.board_state()[0] == "fault":
                detected = tick
            if neutral:
                break
        assert neutral
        fault = self.board_state()
        assert fault[0] == "fault"
        furthest, rest, highest = x, 0, before
        for after in range(1, AFTERWARDS_TICKS):
            furthest = max(furthest, self.x, key=self.along)
            highest = np.maximum(highest, self.chambers)
            rest = rest if abs(self.v) < REST_M_S else after
            assert not np.any(self.tick())
        assert abs(self.v) < REST_M_S
        detected = tick if silent else detected
        return Stop(
            fault=fault[1],
            detection_ticks=detected,
            neutral_ticks=tick - detected,
            v_m_s=v,
            distance_m=self.along(furthest - x),
            rest_ticks=rest,
            x_m=furthest,
            p_before_pa=before,
            p_highest_pa=highest,
        )

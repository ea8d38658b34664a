"""The virtual rig: the board's firmware against the simulated bench, behind a byte port.

The compiled plant loop calls the firmware's host library by function address, so host, wire and
control law are those of the real bench. Time is simulated: it advances only while the client waits
for an answer. The same seed gives the same bytes. A simulated operator switches the supply off
while a zero check is on the board.
"""

from llvmlite import ir
from numba import typeof, types
from numba.extending import intrinsic

from hbench.config.bench import Bench, Plant
from hbench.model.compiled import compiled
from hbench.model.effects.applied import oil_temperature
from hbench.model.plant import P_S, TICK_S, V, forces, step
from hbench.model.scatter import update_levels
from hbench.model.sensing import convert, sensed
from hbench.model.simulated_bench import VOLTS_PER_CODE, new_simulated_bench
from hbench.model.supply import switched_off
from hbench.rig.firmware import POLL_TICKS, HostFirmware


def _call(builder, address, arguments, returns):
    kinds = [argument.type for argument in arguments]
    function = builder.inttoptr(address, ir.FunctionType(returns, kinds).as_pointer())
    return builder.call(function, arguments)


@intrinsic
def _call_tick(typing, address, core, adc, dac):
    """Call ``void tick(core, adc, dac)``; all four are addresses."""

    def generate(context, builder, signature, arguments):
        _call(builder, arguments[0], arguments[1:], ir.VoidType())
        return context.get_dummy_value()

    return types.void(types.intp, types.intp, types.intp, types.intp), generate


@intrinsic
def _call_poll(typing, address, core):
    """Call ``uint32_t poll(core)``; both are addresses."""

    def generate(context, builder, signature, arguments):
        return _call(builder, arguments[0], arguments[1:], ir.IntType(32))

    return types.uint32(types.intp, types.intp), generate


@compiled
def _advance(ticks, poll_ticks, tick, firmware, bench):
    """Run up to ``ticks`` control ticks; stop early when the board has sent a frame.

    ``tick`` counts from power-on; ``firmware`` holds the addresses of the tick and poll functions
    and of the core. Returns the new ``tick``.
    """
    call_tick, call_poll, core = firmware
    words, codes, state, levels, noise, par, sensors, values, u, work = bench
    last = tick + ticks
    while tick < last:
        on_masses = forces(state, levels, par, work[0])
        sensed(state, on_masses, par, values)
        convert(values, oil_temperature(state, par, par.effects), sensors, noise, words)
        _call_tick(call_tick, core, words.ctypes.data, codes.ctypes.data)
        for valve in range(3):
            u[valve] = codes[valve] * VOLTS_PER_CODE
        step(state, u, on_masses, levels, par, TICK_S, work)
        update_levels(levels, state[V], noise, par)
        tick += 1
        if tick % poll_ticks == 0 and _call_poll(call_poll, core) > 0:
            break
    return tick


class VirtualRig:
    """A board and its bench, both simulated, as a ``Port``.

    ``plant`` replaces the bench's own physics. With ``baud`` the line carries baud/10 octets per
    second in each direction, in simulated time; with 0 octets take no time.
    """

    name = "sim"

    def __init__(self, bench: Bench, plant: Plant | None = None, seed: int = 1, baud: int = 0):
        self._bench = new_simulated_bench(bench, plant, seed)
        self._supply = self._bench.par.supply
        self._board = HostFirmware(boots=1, baud=baud)
        self._poll_ticks = 1 if baud else POLL_TICKS
        self._tick = 0
        # Called directly: a dispatcher looks at each of the bench's hundred numbers at each call.
        arguments = 0, self._poll_ticks, self._tick, self._board.addresses, self._bench
        self._advance = _advance.compile(tuple(map(typeof, arguments)))

    def write(self, data: bytes) -> None:
        """Send octets to the board."""
        self._board.receive(data)

    def read(self, timeout_s: float) -> bytes:
        """Simulate until the board sends octets or the timeout is over; return the octets."""
        self._switch_supply(on=not self._board.needs_supply_off)
        ticks = max(1, round(timeout_s / TICK_S))
        self._tick = self._advance(
            ticks, self._poll_ticks, self._tick, self._board.addresses, self._bench
        )
        return self._board.transmit()

    def _switch_supply(self, on: bool) -> None:
        """Switch the pump on or off; the line of a constant supply follows at once."""
        supply = self._supply if on else switched_off(self._supply)
        if supply != self._bench.par.supply:
            self._bench = self._bench._replace(par=self._bench.par._replace(supply=supply))
            if not supply.has_pump:
                self._bench.state[P_S] = supply.pressure_pa

    def now(self) -> float:
        """Simulated seconds since power-on."""
        return self._tick * TICK_S

    def close(self) -> None:
        """Switch the board off."""
        self._board.close()

"""Simulation of the F28335 for its port: registers, time and interrupts.

Written from TI's and Analog Devices' documents, like the port itself: a misreading of them affects
both, and no test reveals it. Each access to a register advances the time. A write to a protected
register without EALLOW, or to a module without clock, has no effect, as on the chip; ``refused``
contains its address.
"""

import ctypes

from tests.support.board.f28335_line import Line

RESET_US = 512 * 2 * 256 / 30  # the watchdog's period with its clock divided by two
WORD_US = 24 * 4 / 37.5  # of 24 bits, at a fourth of LSPCLK
SLOW = 20  # OSCCLK / 4 before the PLL runs, against 150 MHz
ADC_VECTOR, SCI_VECTOR = 0x0D4A, 0x0DC0  # INT1.6 and INT9.1
ILLEGAL_VECTOR = 0x0D26
_SCI = range(0x7050, 0x7060)
_PROTECTED = (range(0x6F80, 0x6FC0), range(0x7010, 0x7030), range(0x0D00, 0x0E00))
_CLOCKED = (  # module, its clock's register and bit
    (range(0x5000, 0x5040), 0x701C, 1 << 12),
    (_SCI, 0x701C, 1 << 10),
    (range(0x7100, 0x711C), 0x701C, 1 << 3),
    (range(0x6800, 0x6822), 0x701D, 1 << 0),
)
_READ = ctypes.CFUNCTYPE(ctypes.c_uint16, ctypes.c_uint16)
_WRITE = ctypes.CFUNCTYPE(None, ctypes.c_uint16, ctypes.c_uint16)
_VECTOR = ctypes.CFUNCTYPE(None, ctypes.c_uint16, ctypes.c_void_p)
_EXECUTE = ctypes.CFUNCTYPE(None, ctypes.c_uint16)
HANDLER = ctypes.CFUNCTYPE(None)


class Chip:
    """Chip after a reset, with the port's ``library`` as its program."""

    def __init__(self, library: ctypes.CDLL):
        self.program = library
        self._callbacks = {
            "hb_read": _READ(self._read),
            "hb_write": _WRITE(self._write),
            "hb_write_vector": _VECTOR(self._write_vector),
            "hb_execute": _EXECUTE(self._execute),
        }
        for name, callback in self._callbacks.items():
            pointer = ctypes.c_void_p.in_dll(library, name)
            pointer.value = ctypes.cast(callback, ctypes.c_void_p).value
        self._ier = ctypes.c_uint16.in_dll(library, "hb_ier")
        self.access_us = 0.04
        self.convert = lambda sensor: 0  # a conversion of ADCINA0 + sensor
        self.adc_dead = self.mcbsp_dead = self.pwm_dead = False
        self.reset()

    def reset(self):
        """Reset the processor, not the DAC and the RAM."""
        self.register = {0x7011: 0x0001, 0x7029: 0x0028}
        self.now_us = self._counted_us = self._event_us = 0.0
        self._slowness = SLOW
        self.vectors, self.pending, self.acknowledged = {}, set(), {1: True, 9: True}
        self.executed, self.refused, self.written = [], [], []
        self.allowed = self.interrupts = self.hung = False
        self.ticks = 0  # control interrupts
        self._next_period_us = None
        self._pass_ends_us, self.results = None, [0] * 16
        self.dac_words, self._dxr, self._shifting, self._shift_ends_us = [], None, None, 0.0
        self.clear_pin = 0  # held down by its resistor
        self.line = Line()
        self.first_sent_at_tick = None
        self._serviced_us, self.was_reset, self._key, self._read_last = 0.0, False, 0, 0

    # For tests.

    def start(self) -> bool:
        """Run the port from reset to its idle loop; codestart.asm turned the watchdog off."""
        self.register[0x7029] = 0x0068
        return bool(self.program.hb_board_start() & 1)

    def run(self, microseconds: float, idle: bool = True):
        """Simulate a time with interrupts, and the idle loop between them."""
        end, self._event_us = self.now_us + microseconds, 0.0
        while self.now_us < end and not (self.hung or self.was_reset):
            if not self.interrupt() and idle:
                self.program.hb_board_idle()
            self.pass_time(2.0)

    def interrupt(self) -> bool:
        """Call the handler of the pending and enabled interrupt of highest priority."""
        for group, vector, enable in ((1, ADC_VECTOR, 0x20), (9, SCI_VECTOR, 0x01)):
            if (
                vector in self.pending
                and self.interrupts
                and self.acknowledged[group]
                and self._ier.value & 1 << (group - 1)
                and self.register.get(0x0CE2 + 2 * (group - 1), 0) & enable
                and self.register.get(0x0CE0, 0) & 1
            ):
                self.pending.remove(vector)
                self.acknowledged[group] = False
                self.interrupts = False
                self.vectors[vector]()
                self.interrupts = not self.hung
                self.ticks += vector == ADC_VECTOR
                return True
        return False

    def receive(self, octets: bytes):
        """Queue octets from the host."""
        self.line.receive(octets, self.now_us)
        self._event_us = 0.0

    # Time.

    def pass_time(self, microseconds: float):
        """Advance the time and process due events."""
        self.now_us += microseconds
        self._counted_us += microseconds / self._slowness
        if self.now_us < self._event_us:
            return
        due = [self._serviced_us + RESET_US]
        self._time_base()
        if self._pass_ends_us is not None and self.now_us >= self._pass_ends_us:
            self._end_pass()
        while self._shifting is not None and self.now_us >= self._shift_ends_us:
            self.dac_words.append(self._shifting)
            self._shifting, self._dxr = self._dxr, None
            self._shift_ends_us += WORD_US * self._slowness
        if self.line.pass_time(self.now_us):
            self.pending.add(SCI_VECTOR)
        self.was_reset |= self.register[0x7029] & 0x40 == 0 and self.now_us > due[0]
        due += [at for at in (self._next_period_us, self._pass_ends_us) if at is not None]
        if self._shifting is not None:
            due.append(self._shift_ends_us)
        due += self.line.due_us()
        self._event_us = min(due)

    def _time_base(self):
        counts = self.register.get(0x701C, 0) & 0x04 and self.register.get(0x6800) == 0x0030
        if not counts or self.pwm_dead:
            self._next_period_us = None
            return
        period_us = (self.register[0x6805] + 1) / 150
        if self._next_period_us is None:
            self._next_period_us = self.now_us + period_us
        while self.now_us >= self._next_period_us:
            self._next_period_us += period_us
            if self.register.get(0x6819) == 0x0A00 and self.register.get(0x681A) == 0x0100:
                self.register[0x681B] = 0x0004
                if self.register.get(0x7101, 0) & 0x0100:
                    self._begin_pass()

    def _begin_pass(self):
        if not self.adc_dead and self.register.get(0x7118) == 0x00E0:
            slots = self.register.get(0x7102, 0) + 1
            window = self.register.get(0x7100, 0) >> 8 & 0xF
            clock_us = self.register.get(0x701A, 0) * 2 / 150
            self._pass_ends_us = self.now_us + slots * (window + 2) * clock_us

    def _end_pass(self):
        self._pass_ends_us = None
        for slot in range(self.register[0x7102] + 1):
            channel = self.register[0x7103 + slot // 4] >> 4 * (slot % 4) & 0xF
            self.results[slot] = self.convert(channel)
        rises = not self.register.get(0x7119, 0) & 1
        self.register[0x7119] = 1
        if rises and self.register[0x7101] & 0x0800:
            self.pending.add(ADC_VECTOR)

    # Accesses of the program.

    def _execute(self, instruction: int):
        name = ("SETC", "CLRC", "EALLOW", "EDIS", "SETFLG", "ADC_CAL", "FOREVER")[instruction]
        self.executed.append(name)
        if name in ("SETC", "CLRC"):
            self.interrupts = name == "CLRC"
        if name in ("EALLOW", "EDIS"):
            self.allowed = name == "EALLOW"
        self.hung |= name == "FOREVER"

    def _refuses(self, address: int) -> bool:
        unclocked = any(
            address in module and not self.register.get(register, 0) & bit
            for module, register, bit in _CLOCKED
        )
        locked = not self.allowed and any(address in area for area in _PROTECTED)
        if unclocked or locked:
            self.refused.append(address)
        return unclocked or locked

    def _write_vector(self, address: int, handler: int):
        if not self._refuses(address):
            self.vectors[address] = HANDLER(handler)

    def _read(self, address: int) -> int:
        waits = self._read_last == address == 0x0C00  # a waiting loop
        self._read_last = address
        self.pass_time(2 * self._slowness if waits else self.access_us)
        if address == 0x0C00:  # counts down from all ones
            return -1 - int(self._counted_us) & 0xFFFF
        if 0x0B00 <= address < 0x0B10:
            return self.results[address - 0x0B00]
        if address == 0x5004:
            ready = self._dxr is None and not self.mcbsp_dead
            return self.register.get(address, 0) & ~2 | (2 if ready else 0)
        if address in _SCI:
            return self.line.read(address)
        return self.register.get(address, 0)

    def _write(self, address: int, value: int):
        self.pass_time(self.access_us)
        if self._refuses(address):
            return
        self.written.append((address, value))
        self._event_us = 0.0
        if address in _SCI:
            if address == 0x7059 and self.first_sent_at_tick is None:
                self.first_sent_at_tick = self.ticks
            self.line.write(address, value, self.now_us)
            return
        special = {
            0x0CE1: self._acknowledge,
            0x5003: self._transmit_word,
            0x681C: lambda value: self._clear(0x681B, value),
            0x6FC2: lambda value: self._set_pin(1, value),
            0x6FC4: lambda value: self._set_pin(0, value),
            0x7025: self._service,
            0x7101: self._control_adc,
            0x7119: lambda value: self._clear(0x7119, value >> 4 & 1),
        }.get(address)
        if special is not None:
            special(value)
            return
        self.register[address] = value
        if address == 0x7011:  # the PLL runs, its output halved
            self._slowness = 1 if value & 0x180 == 0x100 and self.register[0x7021] == 10 else SLOW

    def _clear(self, address: int, bits: int):
        self.register[address] = self.register.get(address, 0) & ~bits

    def _acknowledge(self, value: int):
        for group in self.acknowledged:
            self.acknowledged[group] |= bool(value & 1 << (group - 1))

    def _set_pin(self, level: int, value: int):
        if value & 0x40 and self.register.get(0x6F8A, 0) & 0x40 | (level == 0):
            self.clear_pin = level

    def _transmit_word(self, value: int):
        assert self._dxr is None, "a word is lost"
        word = (self.register.get(0x5002, 0) & 0xFF) << 16 | value
        if self._shifting is None:
            self._shifting = word
            self._shift_ends_us = self.now_us + WORD_US * self._slowness
        else:
            self._dxr = word

    def _service(self, value: int):
        if self._key == 0x55 and value == 0xAA:
            self._serviced_us = self.now_us
        self._key = value

    def _control_adc(self, value: int):
        self.register[0x7101] = value
        if value & 0x4000:
            self._pass_ends_us = None
        if value & 0x2000:
            self._begin_pass()

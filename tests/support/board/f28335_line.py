"""Simulation of the F28335's SCI-A with its FIFOs, and of the line to the host."""

FIFO_OCTETS = 16


class Line:
    """Line that transfers one octet at a time at the baud rate of the registers."""

    def __init__(self):
        self.register = {}
        self.to_board, self.received, self.to_host, self.sent = [], [], [], b""
        self.stopped = self.overflown = False  # receiver after a break, after a FIFO overrun
        self._flag = False
        self._came_us = self._went_us = 0.0

    @property
    def octet_us(self) -> float:
        """Ten bits at LSPCLK / 8 / (BRR + 1)."""
        return 80 * ((self.register[0x7052] << 8 | self.register[0x7053]) + 1) / 37.5

    def receive(self, octets: bytes, now_us: float):
        """Queue octets from the host."""
        if not self.to_board:
            self._came_us = now_us
        self.to_board += octets

    def due_us(self) -> list[float]:
        """Times of the next events."""
        coming = [self._came_us + self.octet_us] if self.to_board else []
        return coming + ([self._went_us + self.octet_us] if self.to_host else [])

    def pass_time(self, now_us: float) -> bool:
        """Process due events; return whether the receive interrupt is requested."""
        requested = False
        if not self.register.get(0x7051, 0) & 0x20:
            return requested
        while self.to_board and now_us >= self._came_us + self.octet_us:
            self._came_us += self.octet_us
            octet = self.to_board.pop(0)
            if self.stopped or self.overflown:
                continue
            if len(self.received) == FIFO_OCTETS:
                self.overflown = True
                continue
            self.received.append(octet)
            if not self._flag and self.register[0x705B] & 0x20:
                self._flag = requested = True
        while self.to_host and now_us >= self._went_us + self.octet_us:
            self._went_us += self.octet_us
            self.sent += bytes([self.to_host.pop(0)])
        return requested

    def read(self, address: int) -> int:
        if address == 0x7055:
            return 0x80 if self.stopped else 0
        if address == 0x7057:
            return 0xC000 | self.received.pop(0)  # error bits above the octet
        if address == 0x705A:
            return 0xE000 | len(self.to_host) << 8
        if address == 0x705B:
            return self.overflown << 15 | len(self.received) << 8 | 0x21
        return self.register.get(address, 0)

    def write(self, address: int, value: int, now_us: float):
        if address == 0x7059:
            assert len(self.to_host) < FIFO_OCTETS, "an octet is lost"
            if not self.to_host:
                self._went_us = now_us
            self.to_host.append(value)
            return
        self.register[address] = value
        if address == 0x7051 and not value & 0x20:
            self.stopped = False
        if address == 0x705B:
            self._flag &= not value & 0x40
            self.overflown &= not value & 0x4000

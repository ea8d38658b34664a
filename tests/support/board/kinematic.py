"""Kinematic plant for the board: speed and pressures follow the commands without dynamics."""

import numpy as np

from hbench.protocol.dictionary import RECORD, RECORD_FLAGS

T = 1e-4
WORD = {word.name: number for number, word in enumerate(RECORD)}
WORD_V_M_S = RECORD[WORD["v"]].scale
AT_REFERENCE, SENSOR_SATURATED, VALVE_SATURATED, LAST, SETTLED = (
    1 << bit for bit in range(len(RECORD_FLAGS))
)


def drive(board, ticks):
    """Simulate a number of ticks; returns the last commands."""
    for _ in range(ticks):
        u_t, u_l1, u_l2 = board.tick()
        board.si["x"] += 0.05 * u_t * T
        board.si["p_lr"] += 3.6e7 * u_l1 * T
        board.si["p_lp"] += 5.6e6 * u_l2 * T
    return u_t, u_l1, u_l2


def run_to_the_end(board, every=20, most_seconds=20.0):
    """Start and run a schedule; returns a status at regular intervals, and the whole log."""
    assert board.start() == b""
    trace = []
    while not trace or (trace[-1]["state"] == 1 and len(trace) * every * T < most_seconds):
        drive(board, every)
        trace.append({**board.status(), "p_lr": board.si["p_lr"], "p_lp": board.si["p_lp"]})
    return trace, read_all(board)


def read_all(board):
    """Return the whole log, one record per row."""
    _, following, _ = board.read_log(0, count=0)
    rows, number = [np.zeros((0, len(RECORD)), "<u2")], 0
    while number < following:
        number, _, words = board.read_log(number)
        rows.append(words)
        number += len(words)
    return np.concatenate(rows)


def signed(column):
    """Return words as signed numbers."""
    return column.astype(np.int16).astype(float)

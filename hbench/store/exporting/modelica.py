"""Friction curves as a text file that Modelica's tables read (CombiTable1Ds).

The file begins with ``#1``; each table is ``double name(rows, columns)`` and its rows. Columns are
velocity [m/s], friction [N] and, if all points have one, the half-width of the 95 % interval.
"""

import re
from collections.abc import Iterable

from hbench.records import KINDS, Curve


def modelica_tables(curves: Iterable[Curve]) -> bytes:
    """Return a table of the points of each curve, and one of each law fitted to it.

    A name consists of ``measured`` or the law, the direction, the load and the label. Rows are in
    order of velocity, as CombiTable1Ds requires.
    """
    lines = [
        "#1",
        "# friction over velocity: v [m/s], F [N]; measured: half-width of the 95 % interval [N]",
    ]
    taken: set[str] = set()
    for curve in curves:
        rows: list[tuple[float, ...]] = [(p.v_m_s, p.friction_n) for p in curve.points]
        intervals = [p.ci95_n for p in curve.points if p.ci95_n is not None]
        if len(intervals) == len(rows):
            rows = [(*row, half) for row, half in zip(rows, intervals, strict=True)]
        lines += _table(_name("measured", curve, taken), rows)
        for fit in curve.fits:
            if fit.line:
                lines += _table(_name(fit.law, curve, taken), list(fit.line))
    return ("\n".join(lines) + "\n").encode()


def _table(name: str, rows: list[tuple[float, ...]]) -> list[str]:
    body = ["  " + " ".join(map(repr, row)) for row in sorted(rows)]
    return ["", f"double {name}({len(rows)},{len(rows[0])})", *body]


def _name(first: str, curve: Curve, taken: set[str]) -> str:
    minus = "minus_" if (curve.f_load_n or 0.0) < 0 else ""
    load = "" if curve.f_load_n is None else f"{minus}{abs(curve.f_load_n):g}N"
    kind = "" if KINDS[curve.kind].has_constant_speed else curve.kind
    if curve.a_ref_m_s2 is not None:
        kind += f"_{curve.a_ref_m_s2:.3g}"
    series = "_".join(filter(None, (first, kind, curve.direction, load, curve.label)))
    name = re.sub(r"\W+", "_", series, flags=re.ASCII)
    number, free = 2, name
    while free in taken:
        number, free = number + 1, f"{name}_{number}"
    taken.add(free)
    return free

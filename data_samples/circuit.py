"""Draws the hydraulic circuit of the bench with the symbols of the README: ``circuit.svg``."""

from pathlib import Path

import matplotlib

matplotlib.use("svg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon, Rectangle

OIL, STEEL, WIRE = "#9ec9e8", "#4d4d4d", "#b04a00"


def cylinder(ax: Axes, left: float, piston: float, rod_to: float, name: str) -> None:
    """A cylinder of length 4 from ``left``, its piston at ``piston``, its rod up to ``rod_to``."""
    ax.add_patch(Rectangle((left, 0), 4, 1.6, facecolor=OIL, edgecolor="black", linewidth=1.5))
    ax.add_patch(Rectangle((piston - 0.12, 0), 0.24, 1.6, facecolor=STEEL))
    start, end = sorted((piston, rod_to))
    ax.add_patch(Rectangle((start, 0.65), end - start, 0.3, facecolor=STEEL))
    ax.text(left + 2, 1.85, name, ha="center", fontsize=11, weight="bold")


def valve(ax: Axes, x: float, name: str, voltage: str) -> None:
    """A 4/3 servo valve: parallel arrows, closed centre, crossed arrows; P and T below."""
    for i in range(3):
        ax.add_patch(Rectangle((x - 0.9 + 0.6 * i, -2.9), 0.6, 0.7, fill=False, linewidth=1.3))
    for start, end in (((-0.75, -2.9), (-0.75, -2.2)), ((-0.45, -2.2), (-0.45, -2.9))):
        _arrow(ax, x, start, end)
    for start, end in (((0.45, -2.9), (0.75, -2.2)), ((0.45, -2.2), (0.75, -2.9))):
        _arrow(ax, x, start, end)
    for port in (-0.15, 0.15):
        for foot, bar in ((-2.9, -2.75), (-2.2, -2.35)):
            ax.plot((x + port, x + port), (foot, bar), color="black", linewidth=1)
            ax.plot((x + port - 0.07, x + port + 0.07), (bar, bar), color="black", linewidth=1)
    ax.text(x + 1.0, -2.4, name, va="center", fontsize=9)
    ax.text(x + 1.0, -2.72, voltage, va="center", fontsize=10, color=WIRE)
    for port, foot, label in ((x - 0.15, -4.0, "P"), (x + 0.15, -4.5, "T")):
        ax.plot((port, port), (-2.9, foot), color="black", linewidth=1.2)
        ax.plot(port, foot, "k.", markersize=5)
        ax.text(port + (0.08 if label == "T" else -0.22), -3.15, label, fontsize=8)


def _arrow(ax: Axes, x: float, start: tuple[float, float], end: tuple[float, float]) -> None:
    style = {"arrowstyle": "-|>", "linewidth": 1, "color": "black", "shrinkA": 0, "shrinkB": 0}
    head = (x + end[0], end[1])
    ax.annotate("", head, (x + start[0], start[1]), arrowprops=style | {"mutation_scale": 7})


def line(ax: Axes, chamber: float, port: float, pressure: str) -> None:
    """A line from a valve to a chamber, with the pressure transducer of the chamber."""
    ax.plot((chamber, chamber, port, port), (0, -1.5, -1.5, -2.2), color="black", linewidth=1.2)
    ax.plot((chamber, chamber + 0.35), (-0.7, -0.7), color="black", linewidth=1)
    ax.add_patch(Circle((chamber + 0.62, -0.7), 0.27, fill=False, linewidth=1.2))
    ax.text(chamber + 0.62, -0.7, "p", ha="center", va="center", fontsize=8)
    ax.text(chamber + 0.98, -0.7, pressure, va="center", fontsize=11, color=WIRE)


def draw() -> plt.Figure:
    """The whole circuit."""
    figure, ax = plt.subplots(figsize=(9.2, 5.4), layout="constrained")
    cylinder(ax, 0, 1.6, 4.9, "test cylinder")
    cylinder(ax, 8.6, 11.0, 5.9, "load cylinder")
    ax.add_patch(Rectangle((4.9, 0.45), 1.0, 0.7, facecolor="white", edgecolor="black"))
    ax.text(5.4, 0.8, "load\ncell", ha="center", va="center", fontsize=8)
    ax.text(5.4, 1.3, r"$F_\mathrm{applied}$", ha="center", fontsize=11, color=WIRE)
    ax.add_patch(Polygon([(6.5, 0.35), (7.9, 0.35), (7.9, 0.65), (6.5, 0.65)], facecolor="#bbbbbb"))
    ax.text(7.2, 0.13, "sledge", ha="center", fontsize=8)

    ax.annotate("", (3.2, 2.7), (1.6, 2.7), arrowprops={"arrowstyle": "-|>", "color": WIRE})
    ax.plot((1.6, 1.6), (2.35, 2.85), color=WIRE, linewidth=0.8, linestyle=":")
    ax.text(3.35, 2.7, r"$x,\ v > 0$: extension", va="center", fontsize=10, color=WIRE)
    ax.annotate("", (9.6, 2.7), (11.0, 2.7), arrowprops={"arrowstyle": "-|>", "color": WIRE})
    opposes = r"$F_L > 0$ opposes extension"
    ax.text(9.45, 2.7, opposes, va="center", ha="right", fontsize=10, color=WIRE)

    valve(ax, 2.0, "test valve", "$u_t$")
    valve(ax, 8.4, "load valve 1", "$u_{l1}$")
    valve(ax, 12.0, "load valve 2", "$u_{l2}$")
    line(ax, 0.5, 1.85, "$P_{Tp}$")
    line(ax, 3.2, 2.15, "$P_{Tr}$")
    line(ax, 9.2, 8.25, "$P_{Lr}$")
    line(ax, 12.2, 11.85, "$P_{Lp}$")

    for height, end in ((-4.0, 13.0), (-4.5, 13.0)):
        ax.plot((-0.2, end), (height, height), color="black", linewidth=1.5)
    ax.add_patch(Circle((-0.55, -4.0), 0.33, fill=False, linewidth=1.3))
    ax.add_patch(Polygon([(-0.3, -4.0), (-0.68, -3.82), (-0.68, -4.18)], facecolor="black"))
    ax.text(-1.0, -3.55, "supply $P_S$", fontsize=10, color=WIRE)
    ax.plot((-0.55, -0.55, -0.2), (-4.72, -4.5, -4.5), color="black", linewidth=1.2)
    ax.plot((-0.8, -0.8, -0.3, -0.3), (-4.6, -4.85, -4.85, -4.6), color="black", linewidth=1.2)
    ax.text(-0.1, -4.85, "tank", fontsize=9)
    ax.set(xlim=(-1.2, 14), ylim=(-5.1, 3.1), aspect="equal")
    ax.axis("off")
    return figure


if __name__ == "__main__":
    matplotlib.rcParams |= {"svg.fonttype": "none", "svg.hashsalt": "circuit"}
    file = Path(__file__).with_name("circuit.svg")
    draw().savefig(file, metadata={"Date": None}, facecolor="white")

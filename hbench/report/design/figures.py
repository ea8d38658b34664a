"""Figures of a design: root locus, Bode with margins, step response, pole-zero map (appendix E)."""

from collections.abc import Callable

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hbench.records import ControlLoop, Design, LoopMerits
from hbench.report.design.loops import PRESENT, loops_by_gains, rate_khz
from hbench.report.design.overview import CAPTION, SECTION, TITLE, overview_figure
from hbench.report.render import style
from hbench.report.render.figures import Drawing, Sketch, draw_sketches
from hbench.report.render.numbers import number

_STEP_RANGE = (-0.5, 2.5)  # shown of step responses where one is unstable
# A colour, a line and a marker for each chain of dynamics.
LOOKS = {
    "ideal valve": (style.COLOURS[0], "-", "o"),
    "valve": (style.COLOURS[1], "--", "s"),
    "board": (style.COLOURS[2], "-.", "^"),
}


def draw_design(design: Design) -> tuple[Drawing, ...]:
    """Draw every kind of figure for every loop, with the present and with the proposed gains.

    The first figure has the margins at all operating points.
    """
    sketches = []
    if design.grid:
        with rc_context(style.RC):
            figure = overview_figure(design)
        sketches.append(Sketch("margins", SECTION, TITLE, CAPTION, figure))
    for gains, loops in loops_by_gains(design).items():
        for loop in loops:
            for name, (draw, title, caption) in FIGURES.items():
                with rc_context(style.RC):
                    figure = draw(loop)
                    figure.axes[0].set_title(f"{title}, {loop.name}")
                    slug = f"{loop.name.replace(' ', '-')}-{name}"
                    slug = slug if gains == PRESENT else f"{gains}-{slug}"
                    full_title = f"{title}, {loop.name}, {gains} gains"
                    words = caption.format(rate=rate_khz(design), gains=gains)
                    sketches.append(
                        Sketch(slug, section_of(gains, loop), full_title, words, figure)
                    )
    return draw_sketches(sketches)


def section_of(gains: str, loop: ControlLoop) -> str:
    """Return the section of the figures of a loop with the present or the proposed gains."""
    return f"{gains} {loop.name}"


def bode(loop: ControlLoop) -> Figure:
    """Draw open-loop gain and phase of every chain, its margins at their frequencies."""
    figure = style.new_figure(height_in=5.4)
    gain, phase = figure.subplots(2, sharex=True)
    for merits in loop.merits:
        colour, line, marker = LOOKS[merits.chain]
        omega, response = merits.omega_rad_s, merits.open_loop
        angle = np.degrees(np.unwrap(np.angle(response)))
        level = 20 * np.log10(np.abs(response))
        margins = [f"PM {number(merits.phase_margin_deg, 0)}°"]
        if np.isfinite(merits.gain_margin):
            margins.append(f"GM {number(20 * np.log10(merits.gain_margin), 1)} dB")
            at = merits.gain_margin_rad_s
            margin = {"color": colour, "label": f"_{merits.chain}, gain margin"}
            gain.plot(at, np.interp(at, omega, level), marker, **margin)
        label = f"{merits.chain}: {', '.join(margins)}"
        gain.plot(omega, level, line, color=colour, label=label)
        phase.plot(omega, angle, line, color=colour, label=f"_{merits.chain}")
        at = merits.phase_margin_rad_s
        if np.isfinite(at):
            margin = {"color": colour, "label": f"_{merits.chain}, phase margin"}
            phase.plot(at, np.interp(at, omega, angle), marker, **margin)
    gain.axhline(0.0, color=style.QUIET, linewidth=1.0)
    phase.axhline(-180.0, color=style.QUIET, linewidth=1.0)
    gain.set(xscale="log", xlim=(1.0, 5e3), ylim=(-60, 60), ylabel="Gain (dB)")
    phase.set(
        xlabel="Frequency (rad/s)",
        ylabel="Phase (°)",
        ylim=(-360, 0),
        yticks=range(-360, 1, 90),
    )
    style.legend_above(figure, gain, columns=1)
    return figure


def step_figure(loop: ControlLoop) -> Figure:
    """Draw the closed loop's unit step response of every chain."""
    figure = style.new_figure(height_in=3.6)
    axes = figure.add_subplot()
    settled = [m.settling_s for m in loop.merits if np.isfinite(m.settling_s)]
    end = min(max([0.05, *settled]) * 1.6, loop.merits[0].t_s[-1])
    for merits in loop.merits:
        colour, line, _ = LOOKS[merits.chain]
        shown = merits.t_s <= end
        if not merits.stable:  # as far as it stays within the axes
            low, high = _STEP_RANGE
            shown &= np.logical_and.accumulate((merits.step > low) & (merits.step < high))
        axes.plot(merits.t_s[shown], merits.step[shown], line, color=colour, label=_name(merits))
    axes.axhspan(0.98, 1.02, color=style.QUIET, alpha=0.15, linewidth=0)
    axes.set(xlabel="Time (s)", ylabel="Response / step (1)", xlim=(0, end), ylim=(0, None))
    if not all(merits.stable for merits in loop.merits):
        axes.set_ylim(_STEP_RANGE)
    style.legend_above(figure, axes, columns=3)
    return figure


def locus(loop: ControlLoop) -> Figure:
    """Draw the closed loop's poles over the gain, without and with the valve."""
    figure = style.new_figure(height_in=4.2)
    axes = figure.add_subplot()
    for merits, branches in zip(loop.merits, loop.locus, strict=False):
        colour, line, marker = LOOKS[merits.chain]
        for branch in branches.poles_rad_s.T:
            label = f"_{merits.chain}, as the gain grows"
            axes.plot(branch.real, branch.imag, line, color=colour, linewidth=1.2, label=label)
        design = branches.poles_rad_s[np.argmin(np.abs(branches.gain_factor - 1.0))]
        axes.plot(design.real, design.imag, marker, color=colour, label=f"{merits.chain}: closed")
        roots = branches.open_poles_rad_s
        label = "open-loop pole" if merits is loop.merits[1] else f"_{merits.chain}, open-loop pole"
        axes.plot(roots.real, roots.imag, "x", color="black", markersize=7, label=label)
    zeros = loop.locus[0].zeros_rad_s
    axes.plot(
        zeros.real,
        zeros.imag,
        "o",
        color="black",
        markerfacecolor="none",
        markersize=8,
        label="zero",
    )
    _s_plane(axes, reach=1.2 * _reach(loop))
    style.legend_above(figure, axes, columns=2)
    return figure


def pole_zero(loop: ControlLoop) -> Figure:
    """Draw the closed loop's poles and zeros in s, and the digital poles in z."""
    figure = style.new_figure(height_in=5.6)
    plane, disc = figure.subplots(2, height_ratios=(1, 1))
    for merits in loop.merits:
        colour, _, marker = LOOKS[merits.chain]
        poles = merits.digital_poles
        disc.plot(
            poles.real,
            poles.imag,
            marker,
            color=colour,
            markerfacecolor="none",
            label=_name(merits),
        )
        if merits.poles_rad_s is not None and merits.zeros_rad_s is not None:
            poles, look = merits.poles_rad_s, {"color": colour}
            plane.plot(poles.real, poles.imag, "x", label=f"{merits.chain}: pole", **look)
            zeros, look["markerfacecolor"] = merits.zeros_rad_s, "none"
            plane.plot(zeros.real, zeros.imag, "o", label=f"{merits.chain}: zero", **look)
    _s_plane(plane, reach=1.2 * _reach(loop))
    angle = np.linspace(0, 2 * np.pi, 721)
    disc.plot(np.cos(angle), np.sin(angle), color=style.QUIET, linewidth=1.0)
    reach = 1.3 * max(0.02, *(np.abs(m.digital_poles.imag).max() for m in loop.merits))
    disc.set(
        xlabel="Re z (unit circle in grey)",
        ylabel="Im z",
        xlim=(1 - 3 * reach, 1 + 0.5 * reach),
        ylim=(-reach, reach),
    )
    style.legend_above(figure, plane, columns=2)
    above = {"loc": "lower left", "bbox_to_anchor": (0, 1), "frameon": False}
    disc.legend(**above, ncols=3, columnspacing=0.8, handletextpad=0.1, borderaxespad=0.1)
    return figure


def _name(merits: LoopMerits) -> str:
    """Return the name of a chain, which states whether it is unstable."""
    return merits.chain if merits.stable else f"{merits.chain} (unstable)"


def _reach(loop: ControlLoop) -> float:
    """Return how far the poles of the designs lie from 0 [rad/s]."""
    return max(np.abs(m.poles_rad_s).max() for m in loop.merits if m.poles_rad_s is not None)


def _s_plane(axes: Axes, reach: float) -> None:
    """Set the axes; the real one is logarithmic beyond 1 rad/s, to part slow roots from fast."""
    axes.axvline(0.0, color=style.QUIET, linewidth=1.0)
    axes.set_xscale("symlog", linthresh=1.0, linscale=0.5)
    axes.set(
        xlabel="Re s (rad/s), logarithmic beyond ±1",
        ylabel="Im s (rad/s)",
        xlim=(-1.5 * reach, reach),
        ylim=(-1.05 * reach, 1.05 * reach),
    )


# Kind: how it is drawn, its title, its caption.
FIGURES: dict[str, tuple[Callable[[ControlLoop], Figure], str, str]] = {
    "locus": (
        locus,
        "Root locus",
        "Closed-loop poles as the gain grows from 1/50 to 50 times the {gains} one, without and "
        "with the valve. Coloured markers: at the {gains} gain. Crosses: open-loop poles. Circle: "
        "the controller's and the plant's zeros.",
    ),
    "step": (
        step_figure,
        "Step response",
        "Response of the closed loop to a unit step of its reference. Grey band: within 2 % of "
        "the step, where the settling time is read. An unstable response ends where it "
        "leaves the figure.",
    ),
    "bode": (
        bode,
        "Bode plot",
        "Open loop. Markers: where the margins are read, on the gain at −180° and on the "
        "phase at 0 dB.",
    ),
    "poles": (
        pole_zero,
        "Poles and zeros",
        "Above: closed-loop poles (crosses) and zeros (circles), without and with the valve. "
        "Below: poles of the loops sampled at {rate} kHz, near z = 1: without and with the valve "
        "by backward Euler, on the board with all three loops closed.",
    ),
}

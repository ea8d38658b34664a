"""The study of the source's instability put together: tables, figures and the explanation."""

from typing import Any

import numpy as np

from hbench.config.bench import parse_bench
from hbench.model.build import plant_parameters
from hbench.records import Finding, Line, Panel, Phenomenon, WordTable
from hbench.studies.instability import (
    FITS,
    SPEEDS_M_S,
    FirmwareRun,
    fastest,
    least_slope,
    ripple,
    tried,
)

# Fits that hold with the load cylinder's friction viscous: fit, B_L [N s/m].
TEST_ALONE = (
    ("6.2 steady", 5500.0),
    ("6.2 steady", 7000.0),
    ("6.5 steady", 4662.0),
    ("6.2 ramp", 7000.0),
    ("6.2 ramp", 9000.0),
    ("6.5 ramp", 7000.0),
)
_EXTRA = ("6.2 ramp", "6.5 ramp")  # drawn beside the steady fits


def instability(bench_data: dict[str, Any]) -> Phenomenon:
    """Show at which speeds the loops hold with the fits of tables 6.2 to 6.5, and why."""
    bench = parse_bench(bench_data, "bench")
    par, control = plant_parameters(bench), bench.controllers
    loops = [
        (loop.gain, loop.time_constant)
        for loop in (control.velocity, control.rod_pressure, control.piston_pressure)
    ]
    mass = par.mass_test_kg + par.mass_load_kg
    filters = control.velocity_filter, control.pressure_filter
    needed, on_board = least_slope(par, loops, (0.0, 0.0)), least_slope(par, loops, filters)
    rates = {
        (name, v): fastest(par, fit, v, loops) for name, fit in FITS.items() for v in SPEEDS_M_S
    }
    runs = {
        (law, name, v): tried(bench_data, fit, law, v)
        for law in ("tustin", "lugre")
        for name, fit in FITS.items()
        for v in SPEEDS_M_S
    }
    alone = {
        (name, viscous, v): tried(bench_data, FITS[name], "tustin", v, viscous)
        for name, viscous in TEST_ALONE
        for v in SPEEDS_M_S
    }
    fine = np.linspace(0.005, 0.2, 80)
    swept = [fastest(par, FITS["6.2 steady"], v, loops) for v in fine]
    return Phenomenon(
        name="instability",
        title="The source's instability",
        text=_text(needed, on_board, mass),
        panels=(
            Panel(
                "slope",
                "Slope of friction, both cylinders",
                "Speed v (mm/s)",
                "Slope of friction (kN s/m)",
                (
                    *(
                        Line(name, 1e3 * fine, np.array([_slope(name, v) for v in fine]) / 1e3)
                        for name in FITS
                        if name.endswith("steady") or name in _EXTRA
                    ),
                    Line("needed", 1e3 * fine, np.full(len(fine), needed / 1e3)),
                ),
            ),
            Panel(
                "eigenvalues",
                "Growth of a disturbance, table 6.2 steady",
                "Speed v (mm/s)",
                "Largest real part (1/s)",
                (
                    Line("plant", 1e3 * fine, np.array([rate.plant for rate in swept])),
                    Line("-F'(v) / (2 m)", 1e3 * fine[::6],
                         np.array([-rate.slope / (2 * mass) for rate in swept[::6]]), points=True),
                    Line("loops closed", 1e3 * fine, np.array([rate.loop for rate in swept])),
                    Line("a tenth of the gain", 1e3 * fine,
                         np.array([rate.tenth for rate in swept])),
                    Line("loops closed, LuGre", 1e3 * fine,
                         np.array([rate.lugre for rate in swept])),
                ),
            ),
            _velocity("static", runs, "tustin", ("6.2 steady", "6.5 steady")),
            _velocity("lugre", runs, "lugre", ("6.2 steady", "6.5 steady")),
        ),
        findings=tuple(
            Finding(
                f"plant, {name} at 50 mm/s", "1/s", rates[name, 0.05].plant,
                -rates[name, 0.05].slope / (2 * mass), "-F'(v) / (2 m); valid while it oscillates"
            )
            for name in ("6.2 steady", "6.3 steady", "6.4 steady", "6.5 steady", "6.5 ramp")
        )
        + (
            Finding("slope needed at 50 mm/s, loops as printed", "N s/m", needed, None,
                    "zero of the largest real part"),
            Finding("slope needed at 50 mm/s, on the board", "N s/m", on_board, None,
                    "sampled at 10 kHz, with its filters"),
        ),
        tables=(
            WordTable(
                "Largest real parts of the eigenvalues (1/s); positive: unstable",
                ("fit", "v (mm/s)", "slope F' (N s/m)", "plant", "loops closed",
                 "a tenth of K_c", "loops closed, LuGre"),
                tuple(
                    (name, f"{1e3 * v:g}", f"{rate.slope:.0f}",
                     *(f"{value:+.1f}" for value in rate[1:]))
                    for (name, v), rate in rates.items()
                ),
            ),
            WordTable(
                "The firmware in closed loop with the nonlinear bench, from rest, 5 kN: standard "
                "deviation of the speed (mm/s), or the fault that ended the run",
                ("friction", "fit", *(f"{1e3 * v:g} mm/s" for v in SPEEDS_M_S)),
                tuple(
                    ({"tustin": "static", "lugre": "LuGre, both cylinders"}[law], name,
                     *(_verdict(runs[law, name, v]) for v in SPEEDS_M_S))
                    for law in ("tustin", "lugre")
                    for name in FITS
                )
                + tuple(
                    (f"static in the test cylinder alone, B_L = {viscous:g} N s/m", name,
                     *(_verdict(alone[name, viscous, v]) for v in SPEEDS_M_S))
                    for name, viscous in TEST_ALONE
                ),
            ),
        ),
    )  # fmt: skip


def _text(needed: float, on_board: float, mass: float) -> tuple[str, ...]:
    return (
        "The source fitted Tustin's law (3.2) to its measurements, and reports that its simulation "
        "with the fitted friction was unstable, so that the models could not be verified. Here the "
        "fits of tables 6.2 to 6.5 are the friction of both cylinders of the reconstructed bench, "
        "with the printed controllers (table 4.1, with the rod-side gain of this bench file).",
        "Cause. The fits have F_C near 0, on the bound of table 6.1, so nearly all of the stiction "
        "falls off with speed, and the slope of friction F'(v) = B - (F_s - F_C) / v_s "
        "exp(-v / v_s) is negative up to 100 to 150 mm/s: at 50 mm/s both cylinders of table 6.2 "
        "together have -4.8 kN s/m. As a static law this acts at once. The masses "
        f"({mass:g} kg) swing on the oil's springs with a negative damper: the equation of motion "
        "(2.9) and the pressure gradients (2.1 to 2.8) give a pair of eigenvalues with the real "
        "part -F'(v) / (2 m) as long as it oscillates: +239 1/s for table 6.2, steady, and +107 "
        "1/s for 6.5, steady, at 50 mm/s. The plant itself is unstable, before any controller.",
        "The controllers cannot stabilise it. The valve (2.16) has 90 Hz; the velocity loop lags "
        "where it would have to damp, and removes damping. A tenth of its gain changes little "
        "where the plant is unstable; where it is not (197 mm/s), that would hold. "
        f"With the printed gains the loops hold where F'(v) is above {needed / 1e3:.2f} "
        f"kN s/m, on the board with its filters and sampling {on_board / 1e3:.2f} kN s/m (both "
        "cylinders, 50 mm/s, 5 kN). Of all fits and speeds in the table only 6.5, steady, at "
        "197 mm/s is above it, and it alone holds.",
        "What holds. First, LuGre (3.8 to 3.12) with the same fits and sigma_0 = 1e5 N/m: the "
        "falling part comes through bristles, as F_dry' / (1 + s tau), tau = F_dry / (sigma_0 v). "
        "At 50 mm/s tau is 75 ms, so that at the oil's frequency, 270 rad/s, friction looks "
        "viscous with B_T + B_L alone. That is 2.7 to 4.7 kN s/m in the steady fits, which hold, "
        "and at most 1.4 kN s/m in the ramp fits, which don't hold: the source itself calls the "
        "viscous coefficients of table 6.2 corrupted. Table 6.2, steady, at 197 mm/s is at the "
        "edge: its eigenvalue of +0.6 1/s needs longer than the stroke lasts. Eigenvalues hold "
        "for small disturbances: on the board's return at 150 mm/s, tables 6.2 and 6.3 enter a "
        "cycle, tables 6.4 and 6.5 do not. Stiffer bristles approach the static law: with "
        "sigma_0 = 1e6 N/m table 6.2 is unstable again at 50 mm/s.",
        "Second, the static fit in the test cylinder alone, with a viscous load cylinder that "
        "restores the slope: B_L from about 5 kN s/m at 50 mm/s, 7 kN s/m down to 10 mm/s for "
        "table 6.2, steady. The measured friction is the test cylinder's; that the source put it "
        "in both is an assumption of this reconstruction.",
        "The static law caused the instability, not the measured friction. A Stribeck curve "
        "measured at steady speed does not determine how fast friction follows a change of speed, "
        "and a static law assumes that it follows at once.",
        "What is assumed. The source's masses, oil stiffness and operating point are not printed; "
        "those of the bench file are used; its comments give their status. F_C 'about 0' is read "
        "as 1 N. -F'(v) / (2 m) does not depend on the oil, and heavier masses slow the growth but "
        "don't end it. Position 170 mm (firmware: from 200 mm), load 5 kN, 15 bar on its rod side.",
    )


def _slope(name: str, v: float) -> float:
    """Return F'(v) [N s/m] of both cylinders: the derivative of 3.2."""
    fit = FITS[name]
    fallen = (fit.stiction_n - fit.coulomb_n) * np.exp(-v / fit.stribeck_velocity_m_s)
    return 2 * (fit.viscous_n_s_m - fallen / fit.stribeck_velocity_m_s)


def _verdict(done: FirmwareRun) -> str:
    off = ripple(done.run)
    fault = done.fault.partition(":")[0].replace("_", " ")
    if not fault:
        return f"holds, {1e3 * off:.1f}"
    return f"{1e3 * off:.0f}, {fault}" if np.isfinite(off) else fault


def _velocity(
    panel: str, runs: dict[tuple[str, str, float], FirmwareRun], law: str, fits: tuple[str, ...]
) -> Panel:
    lines = []
    for name in fits:
        run = runs[law, name, 0.05].run
        shown = run.t_s - run.t_s[0] < 0.6
        t = (run.t_s - run.t_s[0])[shown]
        lines.append(Line(name, t, 1e3 * run.channel("v_m_s")[shown]))
        reference = Line("reference", t, 1e3 * run.channel("v_ref_m_s")[shown])
    use = {"tustin": "as a static law", "lugre": "as LuGre, sigma_0 = 1e5 N/m"}[law]
    title = f"50 mm/s with the fits {use}"
    return Panel(panel, title, "Time (s)", "Velocity (mm/s)", (*lines, reference))

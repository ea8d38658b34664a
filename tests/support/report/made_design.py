"""A design of one control loop, made up from few records."""

import numpy as np

from hbench.records import (
    Check,
    ControlLoop,
    Design,
    LoopMerits,
    Proposal,
    Reproduced,
    RootLocus,
)
from hbench.report.design.figures import draw_design
from hbench.report.render.figures import Drawing
from tests.support.shared import once

OMEGA, T = np.geomspace(1, 1e4, 300), np.linspace(0, 0.5, 200)


def merits(chain, poles):
    """An integrating loop k/s closed to a first-order lag."""
    return LoopMerits(
        chain=chain,
        bandwidth_rad_s=100.0,
        phase_margin_deg=90.0,
        gain_margin=np.inf if chain == "ideal valve" else 4.0,
        phase_margin_rad_s=100.0,
        gain_margin_rad_s=np.inf if chain == "ideal valve" else 500.0,
        overshoot=0.0,
        settling_s=np.inf,
        digital_modulus=0.99,
        omega_rad_s=OMEGA,
        open_loop=100 / (1j * OMEGA),
        t_s=T,
        step=1 - np.exp(-100 * T),
        digital_poles=np.array([0.99 + 0j]),
        poles_rad_s=poles,
        zeros_rad_s=poles if poles is None else poles[:0],
    )


def drawings_of_design() -> tuple[Drawing, ...]:
    """Return the figures of ``made_design``."""
    return once("drawings-design", lambda: draw_design(made_design()))


def made_design() -> Design:
    """Return the design of one loop, with a proposal that fails a check."""
    factors = np.array([0.5, 1.0, 2.0])
    locus = RootLocus(factors, -100.0 * factors[:, None] + 0j, np.array([0j]), np.array([]))
    pole = np.array([-100.0 + 0j])
    chains = (merits("ideal valve", pole), merits("valve", pole), merits("board", None))
    loop, proposed = (
        ControlLoop("velocity", "T", gain, "V/m", tau_s, chains, (locus, locus))
        for gain, tau_s in ((800.0, 0.06), (1500.0, 0.018))
    )
    names = "x_m v_m_s p_tp_pa p_tr_pa p_lp_pa p_lr_pa u_t_v u_l1_v u_l2_v viscous_n_s_m".split()
    checks = (Check("velocity: phase margin", 50.0, 45.0, "deg", True, "x 5 mm"),)
    failed = (Check("bench: rejected runs", 2.0, 0.0, "runs", False, "<+200 mm/s>"),)
    return Design(
        bench="<b>bench</b>",
        point=dict.fromkeys(names, 1.0),
        f_load_n=500.0,
        coefficients={"beta": 7e7},
        jacobian_difference=1e-9,
        loops=(loop,),
        feedforward=(5.7, 34.0),
        ramp_error_m_s=1.67e-3,
        coupled_modulus=0.999,
        tick_s=1e-4,
        reproduced=(Reproduced("closed pole", "rad/s", "-110.76", -148.4, 0.34, False, "why"),),
        proposal=Proposal(
            {"velocity": (1500.0, 0.018)}, {"velocity": 200.0}, (5.0, 20.0), 1.7, 54, (), checks,
            failed, (proposed,),
        ),
    )  # fmt: skip

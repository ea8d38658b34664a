"""Logs of the plant without noise, sensors or a controller: means over records of 10 ms."""

from dataclasses import replace

import numpy as np

from hbench.config.sensors import ForceInstrument, Instruments, PressureInstrument
from hbench.model.plant import P_LP, P_LR, P_S, P_TP, P_TR, V, X, initial_state
from hbench.model.simulation import simulate
from hbench.records import Run, RunPlan, Specimen

TICKS = 100  # of 100 us, in a record
RECORD_S = 0.01
SPECIMEN = Specimen(1e-3, 8e-4)
INSTRUMENTS = Instruments(
    force=ForceInstrument.model_construct(tolerance=0.01, of="reading", full_scale=2e4),
    pressure=PressureInstrument.model_construct(tolerance=0.002, of="full_scale", full_scale=25e6),
)


def smooth_strokes(seconds=2.6):
    """Commands (n, 3) of a stroke out and one back, at rest before, between and after.

    They change smoothly: within a record a parabola describes them.
    """
    t = (np.arange(round(seconds / 1e-4)) + 0.5) * 1e-4
    out, back = _bump(t, 0.2, 1.2), _bump(t, 1.4, 2.4)
    extend, retract = np.array([0.9, 0.35, -1.8]), np.array([-0.8, -1.0, 0.5])
    return out[:, None] * extend + back[:, None] * retract


def _bump(t, start, stop):
    s = np.clip((t - start) / (stop - start), 0.0, 1.0)
    return np.sin(np.pi * s) ** 2 * (1 + 0.3 * np.sin(6 * np.pi * s))


def logged(run: str, par, state, commands, trial=1):
    """Return the log of a motion from ``state``, the plant's trajectory, and its friction.

    Friction is (2, n): of the test and the load cylinder, means over the records.
    """
    made = simulate(par, state, commands)
    columns = {
        "x_m": X, "p_tp_pa": P_TP, "p_tr_pa": P_TR, "p_lp_pa": P_LP, "p_lr_pa": P_LR, "p_s_pa": P_S,
        "v_m_s": V,
    }  # fmt: skip
    channels = {name: record_means(made.state[:, at]) for name, at in columns.items()}
    u = commands.reshape(-1, TICKS, 3).mean(axis=1).T
    log = Run(
        plan=RunPlan(run, "steady", trial, 0.05, SPECIMEN),
        t_s=(np.arange(u.shape[1]) + 0.5) * RECORD_S,
        f_applied_n=record_means(made.f_applied_n),
        u_t_v=u[0],
        u_l1_v=u[1],
        u_l2_v=u[2],
        **channels,
    )
    return log, made


def logged_points(par, shares):
    """Return logs with noisy pressures: an operating point for each share of the usual commands.

    Its two trials differ a little in the pressure at the start.
    """
    rng, made = np.random.default_rng(0), []
    for number, share in enumerate(shares):
        commands = share * smooth_strokes()
        for trial in (1, 2):
            start = initial_state(par, 0.15, 15e5, (19 + number + 0.1 * trial) * 1e5)
            log, _ = logged(f"{2 * number + trial:04d}", par, start, commands, trial)
            noisy = {
                name: getattr(log, name) + 500 * rng.standard_normal(len(log.t_s))
                for name in ("p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa", "p_s_pa")
            }
            made.append(replace(log, plan=replace(log.plan, v_ref_m_s=0.01 * number), **noisy))
    return tuple(made)


def record_means(samples):
    """Return the means over the records of samples (n + 1,) at every tick."""
    middle = 0.5 * (samples[1:] + samples[:-1])
    return middle.reshape(-1, TICKS).mean(axis=1)

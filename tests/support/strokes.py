"""Logs of a made-up bench in SI: strokes of known friction."""

import numpy as np

PISTON_M, ROD_M = 0.040, 0.025
AREA_P, AREA_R = np.pi / 4 * PISTON_M**2, np.pi / 4 * (PISTON_M**2 - ROD_M**2)
P_R = 8e5


def friction(v_m_s):
    """Coulomb and viscous friction [N]."""
    return 150 * np.sign(v_m_s) + 900 * v_m_s


def _log(t_s, v_m_s, load_n, seed):
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal((4, len(t_s)))
    x = 0.02 + np.concatenate(([0], np.cumsum((v_m_s[1:] + v_m_s[:-1]) / 2 * np.diff(t_s))))
    p_tp = (load_n + friction(v_m_s) + P_R * AREA_R) / AREA_P
    return {
        "t_s": t_s,
        "x_m": x + 1e-5 * noise[0],
        "p_tp_pa": p_tp + 2e3 * noise[1],
        "p_tr_pa": P_R + 2e3 * noise[2],
        "f_applied_n": load_n + 2 * noise[3],
    }


def one_stroke(v_m_s, load_n, seed=0, rate_hz=100.0):
    """An extending stroke of 2.5 s after a second at rest, under load throughout."""
    t = np.arange(0, 3.5, 1 / rate_hz)
    return _log(t, np.where(t < 1.0, 0.0, v_m_s), load_n, seed)


def there_and_back(v_m_s, load_n, seed=0, rate_hz=100.0, cycles=3):
    """Strokes of 3 s in both directions, with rests of 0.3 s at their ends."""
    t = np.arange(0, 1.3 + 6.6 * cycles, 1 / rate_hz)
    phase = (t - 1.0) % 6.6
    v = np.select([t < 1.0, phase < 3, phase < 3.3, phase < 6.3], [0, v_m_s, 0, -v_m_s], 0.0)
    return _log(t, np.where(t > 1.0 + 6.6 * cycles, 0.0, v), load_n, seed)

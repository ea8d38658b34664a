"""The plant's own steps against scipy at tight tolerance, from a start over a reversal to rest."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hbench.model.plant import P_LR, P_TP, TICK_S, V, derivatives, initial_state
from hbench.model.simulation import simulate

BAR = 1e5
ATOL = np.array([1e-10, 1e-8, *[0.1] * 4, *[1e-8] * 3, *[1e-6] * 3, 0.1, 1e-9, 1e-9, 1e-11, 1e-11])


def reference(rhs, state0, commands):
    """Integrate piece by piece, where the commands are held, with scipy's LSODA."""
    edges = [0, *(np.flatnonzero(np.any(np.diff(commands, axis=0), axis=1)) + 1), len(commands)]
    states = [state0[None]]
    for first, last in zip(edges[:-1], edges[1:], strict=True):
        t = np.arange(first, last + 1) * TICK_S
        solution = solve_ivp(
            rhs, (t[0], t[-1]), states[-1][-1], "LSODA", t, args=(commands[first],),
            rtol=1e-9, atol=ATOL,
        )  # fmt: skip
        assert solution.success
        states.append(solution.y.T[1:])
    return np.concatenate(states)


def compiled_rhs(par):
    def rhs(t, y, u):
        out = np.empty_like(y)
        derivatives(y, u, np.ones(2), par, out)
        return out

    return rhs


def written_out_rhs(bench, law):
    """Equations 2.1 to 2.18, 3.2 and 3.8 to 3.12 from the bench file, in plain Python."""
    area_p, area_r = np.pi / 4 * 0.04**2, np.pi / 4 * (0.04**2 - 0.025**2)
    p_s, p_t, beta, omega = 150e5, 2e5, 700e5, 2 * np.pi * 90
    k_s = 7.43e-7 * np.sqrt(2 / 870)

    def root(dp):
        return dp / (dp**2 + 1e6) ** 0.25

    def friction(v, z, p_p, p_r, par):
        seal = par.piston_seal * abs(p_p - p_r) + par.rod_seal * p_r
        stribeck = np.exp(-((abs(v) / par.stribeck_velocity) ** par.stribeck_exponent))
        dry = seal + par.coulomb + (par.stiction - par.coulomb) * stribeck
        if law == "tustin":
            return np.tanh(v / 1e-3) * dry + par.viscous * v, 0.0
        sigma_0 = par.bristle_stiffness
        z_dot = v - abs(v) / (dry / sigma_0) * z
        return sigma_0 * z + par.bristle_damping * z_dot + par.viscous * v, z_dot

    def rhs(t, y, u):
        x, v, p_tp, p_tr, p_lp, p_lr, y_t, y_1, y_2, r_t, r_1, r_2, _, _, _, z_t, z_l = y
        if y_t >= 0:
            q_tp, q_tr = k_s * y_t * root(p_s - p_tp), k_s * y_t * root(p_tr - p_t)
        else:
            q_tp, q_tr = k_s * y_t * root(p_tp - p_t), k_s * y_t * root(p_s - p_tr)
        q_lr = k_s * y_1 * root(p_s - p_lr if y_1 >= 0 else p_lr - p_t)
        q_lp = k_s * y_2 * root(p_s - p_lp if y_2 >= 0 else p_lp - p_t)
        f_t, z_t_dot = friction(v, z_t, p_tp, p_tr, bench.friction.test)
        f_l, z_l_dot = friction(v, z_l, p_lp, p_lr, bench.friction.load)
        force = p_tp * area_p + p_lr * area_r - p_tr * area_r - p_lp * area_p - f_t - f_l
        return [
            v,
            force / 10.0,
            beta / (251.2e-6 + area_p * x) * (q_tp - area_p * v),
            beta / (251.2e-6 + area_r * (0.4 - x)) * (area_r * v - q_tr),
            beta / (199.3e-6 + area_p * (0.4 - x - 0.02)) * (q_lp + area_p * v),
            beta / (112.7e-6 + area_r * (x + 0.02)) * (q_lr - area_r * v),
            r_t,
            r_1,
            r_2,
            omega**2 * (u[0] - y_t) - 2 * omega * r_t,
            omega**2 * (u[1] - y_1) - 2 * omega * r_1,
            omega**2 * (u[2] - y_2) - 2 * omega * r_2,
            0.0,  # constant supply
            0.0,
            0.0,
            z_t_dot,
            z_l_dot,
        ]

    return rhs


@pytest.fixture(scope="module", params=["lugre", "tustin"])
def run(request, with_law, there_and_back):
    par = with_law(request.param)
    state = initial_state(par, 0.15, 15 * BAR, 20 * BAR)
    return request.param, par, simulate(par, state, there_and_back)


def largest_relative_difference(run, states):
    """Of velocity and pressures, to each one's range over the run."""
    columns = slice(V, P_LR + 1)
    return np.max(
        np.abs(run.state - states)[:, columns].max(axis=0) / np.ptp(states[:, columns], axis=0)
    )


def test_the_run_starts_reverses_and_stops_without_cavitation(run):
    _, _, trajectory = run
    assert trajectory.state[:, V].max() > 0.04
    assert trajectory.state[:, V].min() < -0.04
    assert np.abs(trajectory.state[-500:, V]).max() < 1e-3
    assert trajectory.state[:, P_TP : P_LR + 1].min() > 2 * BAR


def test_steps_converge_to_scipy_on_the_same_equations(run):
    _, par, trajectory = run
    states = reference(compiled_rhs(par), trajectory.state[0], trajectory.u_v)
    assert largest_relative_difference(trajectory, states) < 2e-5


def test_steps_converge_to_scipy_on_equations_written_out_anew(run, bench):
    law, _, trajectory = run
    states = reference(written_out_rhs(bench, law), trajectory.state[0], trajectory.u_v)
    assert largest_relative_difference(trajectory, states) < 2e-5

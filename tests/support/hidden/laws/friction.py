"""Friction and inertia of the hidden plants. Each law is neutral where its amounts are 0."""

from math import copysign, cos, exp, log, pi, sin, sqrt

from hbench.model.compiled import inlined
from hbench.model.cylinders import pressure_force
from hbench.model.effects.couplings import FrictionTerms
from hbench.model.friction.laws import steady_parts
from hbench.model.states import P_LP, P_LR, P_TP, P_TR, V, X


@inlined
def rougher(f, test, load):
    """Friction with larger dry parts [N]."""
    return FrictionTerms(f.dry_t, f.dry_l, f.more_t + test, f.more_l + load, f.force_t, f.force_l)


@inlined
def held(f, test, load):
    """Friction with further forces [N], positive against extension."""
    return FrictionTerms(f.dry_t, f.dry_l, f.more_t, f.more_l, f.force_t + test, f.force_l + load)


def seal_pressure_friction(f, c, state, at, rates, par):
    """Lips pressed by the piston side's pressure, less than in proportion."""
    test, load, exponent = c
    if test == 0.0 and load == 0.0:
        return f
    return rougher(
        f,
        test * (max(state[P_TP], 0.0) / 50e5) ** exponent,
        load * (max(state[P_LP], 0.0) / 50e5) ** exponent,
    )


@inlined
def saturating(force, limit):
    """|F| that grows ever less."""
    return abs(force) / (1.0 + abs(force) / limit)


def load_friction(f, c, state, at, rates, par):
    test, load, limit = c
    if test == 0.0 and load == 0.0:
        return f
    f_test = pressure_force(state[P_TP], state[P_TR], par.test)
    f_load = pressure_force(state[P_LP], state[P_LR], par.load)
    return rougher(f, test * saturating(f_test, limit), load * saturating(f_load, limit))


def direction_asymmetry(f, c, state, at, rates, par):
    """Grows with the speed."""
    test, load, speed = c
    if test == 0.0 and load == 0.0:
        return f
    v = state[V]
    way = v / sqrt(v * v + 1e-6) * (1.0 + abs(v) / speed)
    return rougher(f, way * test * f.dry_t, way * load * f.dry_l)


@inlined
def dry_at(speed, state, par):
    v = copysign(speed, state[V])
    test, _ = steady_parts(v, state[P_TP], state[P_TR], 1.0, par.test.friction)
    load, _ = steady_parts(v, state[P_LP], state[P_LR], 1.0, par.load.friction)
    return abs(test), abs(load)


def friction_lag(f, c, state, at, rates, par):
    """The film's thickness follows the logarithm of the speed."""
    time, least = c
    rates[at] = 0.0
    if time == 0.0:
        return f
    speed = abs(state[V])
    rates[at] = (log(1.0 + speed / least) - state[at]) / time
    test, load = dry_at(speed, state, par)
    then_test, then_load = dry_at(least * (exp(state[at]) - 1.0), state, par)
    return rougher(f, then_test - test, then_load - load)


def presliding(f, c, state, at, rates, par):
    """Two elastic elements, one six tenths of the force over a short, one over a long way."""
    force, short, long = c
    if force == 0.0:
        rates[at] = rates[at + 1] = 0.0
        return f
    v = state[V]
    rates[at] = (v - abs(v) * state[at]) / short
    rates[at + 1] = (v - abs(v) * state[at + 1]) / long
    elastic = 0.6 * state[at] + 0.4 * state[at + 1]
    return held(rougher(f, -force, 0.0), force * elastic, 0.0)


def position_friction(f, c, state, at, rates, par):
    """A tight place, or a slow wave, along the bore of the test cylinder."""
    bump, wave, middle, width, period, phase = c
    if bump == 0.0 and wave == 0.0:
        return f
    away = (state[X] - middle) / width
    more = bump * exp(-0.5 * away * away) + wave * cos(2.0 * pi * state[X] / period + phase)
    return rougher(f, more, 0.0)


def oil_warming(f, c, state, at, rates, par):
    """The room and the pump warm the oil, whatever the bench does: viscosity 1 / (1 + k theta)."""
    rise, time, viscosity = c
    rates[at] = 0.0
    if rise == 0.0:
        return f
    rates[at] = (1.0 - state[at]) / time
    change = (1.0 / (1.0 + viscosity * rise * state[at]) - 1.0) * state[V]
    return held(f, change * par.test.friction.viscous, change * par.load.friction.viscous)


def end_cushion(f, c, state, at, rates, par):
    """Trapped oil leaves through a sharp orifice: its force grows with the speed's square."""
    damping, length = c
    if damping == 0.0:
        return f
    v, position = state[V], state[X] + par.test.offset_m
    left = par.test.stroke_m - position if v > 0.0 else position
    return held(f, damping * max(1.0 - left / length, 0.0) * abs(v) * v, 0.0)


def added_mass(f, c, state, at, rates, par):
    """A column of oil, longer as the piston goes out, dragged along by its viscosity."""
    test, load, time = c
    rates[at] = 0.0
    if test == 0.0 and load == 0.0:
        return f
    rates[at] = (state[V] - state[at]) / time
    share = 0.6 + 0.8 * state[X] / par.test.stroke_m
    return held(f, test * share * rates[at], load * share * rates[at])


# ---- what the catalogue does not have


def bore_ripple(f, c, state, at, rates, par):
    """Background: dry friction varies by a share along the bores of both cylinders."""
    share, period, phase = c
    if share == 0.0:
        return f
    angle = 2.0 * pi * state[X] / period + phase
    return rougher(f, share * sin(angle) * f.dry_t, share * cos(angle) * f.dry_l)


def friction_level(f, c, state, at, rates, par):
    """Background: dry friction of this run against that of the bench; ``measure.py`` changes it."""
    test, load = c
    return rougher(f, test * f.dry_t, load * f.dry_l)


def guide_misalignment(f, c, state, at, rates, par):
    """A side load that grows as the rod comes out, under load."""
    (share,) = c
    if share == 0.0:
        return f
    pressed = abs(pressure_force(state[P_TP], state[P_TR], par.test))
    out = max(state[X] / par.test.stroke_m, 0.0)
    return rougher(f, share * out * out * pressed, 0.0)


def bore_chatter(f, c, state, at, rates, par):
    """A bore that was honed with chatter marks."""
    force, period, phase = c
    if force == 0.0:
        return f
    return rougher(f, force * sin(2.0 * pi * state[X] / period + phase), 0.0)


def rest_film(f, c, state, at, rates, par):
    """The film is squeezed out at rest, and comes back over a way: dry friction is larger."""
    share, length, time = c
    rates[at] = 0.0
    if share == 0.0:
        return f
    speed = abs(state[V])
    rates[at] = -state[at] * speed / length
    if speed < 1e-3:
        rates[at] = (1.0 - state[at]) / time
    return rougher(f, share * state[at] * f.dry_t, 0.0)

"""Logs that contradict the model: commands of the wrong sign, cylinders of another size.

The strokes are written down by hand, with friction that is not hbench's: its dry part falls with
the square root of the velocity, and a part of it grows with the pressure on the rod side.
"""

from dataclasses import replace

import numpy as np
import pytest

from hbench.config.bench import parse_plant
from hbench.errors import DataError
from hbench.reconcile.measured.balances import balance_model
from hbench.reconcile.measured.contradictions import refuse_contradictions
from hbench.reconcile.measured.moving_windows import moving_windows
from hbench.reconcile.measured.session import sessions
from hbench.records import Run, RunPlan, Specimen

BAR = 1e5
NO_AREAS = Specimen(0.0, 0.0)  # not stated by the campaign: pressures and forces alone show them


@pytest.fixture(scope="module")
def model(bench_data):
    return balance_model(None, parse_plant(bench_data, {}, ""))


@pytest.fixture(scope="module")
def runs(model):
    return strokes(model, wander=0.03)


def strokes(model, wander):
    """36 steady strokes at three speeds, three loads and two pressures, in both directions."""
    test, load = model.par.test, model.par.load
    rng, made = np.random.default_rng(3), []
    for v in (-0.12, -0.05, -0.02, 0.02, 0.05, 0.12):
        for force in (-3e3, 500.0, 4e3):
            for p_back in (20 * BAR, 60 * BAR):
                t = np.arange(150) * 0.01
                dry = (300 - 200 * np.sqrt(abs(v))) * (1 + wander * rng.standard_normal())
                friction = np.sign(v) * (dry + 0.4 * p_back / BAR) + 1500 * v
                p_tp = (force + friction + p_back * test.area_rod_m2) / test.area_piston_m2
                p_lr = p_back + 10 * BAR
                p_lp = (force - friction + p_lr * load.area_rod_m2) / load.area_piston_m2
                pressures = {"p_tp_pa": p_tp, "p_tr_pa": p_back, "p_lp_pa": p_lp, "p_lr_pa": p_lr}
                channels = {
                    name: mean + 0.05 * BAR * rng.standard_normal(len(t))
                    for name, mean in pressures.items()
                }
                plan = RunPlan(f"{len(made):04d}", "steady", 1, v, NO_AREAS, f_load_n=force)
                commands = {"u_t_v": 12 * v, "u_l1_v": 9 * v, "u_l2_v": -11 * v}
                made.append(
                    Run(
                        plan,
                        t,
                        0.2 - v * 0.75 + v * t + 2e-6 * rng.standard_normal(len(t)),
                        f_applied_n=force + 3 * rng.standard_normal(len(t)),
                        p_s_pa=np.full(len(t), 150 * BAR),
                        **channels,
                        **{name: np.full(len(t), u) for name, u in commands.items()},
                    )
                )
    return tuple(made)


def refused(runs, model):
    with pytest.raises(DataError) as caught:
        refuse_contradictions(sessions(runs), model)
    return caught.value


def with_test_valve(runs, factor):
    return [replace(run, u_t_v=factor * run.u_t_v) for run in runs]


def with_thinner_rod(model, part):
    """The model with a rod that is 5 mm thinner, and the diameter [m] that would fit."""
    own = getattr(model.par, part)
    rod_m = np.sqrt((own.area_piston_m2 - own.area_rod_m2) * 4 / np.pi)
    thinner = own.area_piston_m2 - np.pi / 4 * (rod_m - 5e-3) ** 2
    par = model.par._replace(**{part: own._replace(area_rod_m2=thinner)})
    return replace(model, par=par), rod_m


def test_consistent_logs_are_not_refused_unless_a_valve_or_a_rod_is_wrong(runs, model):
    refuse_contradictions(sessions(runs), model)
    refused(with_test_valve(runs, -1), model)
    refused(runs, with_thinner_rod(model, "test")[0])


def test_a_load_cell_whose_gain_is_wrong_is_left_to_the_search(runs, model):
    wrong = [replace(run, f_applied_n=1.08 * run.f_applied_n) for run in runs]
    refuse_contradictions(sessions(wrong), model)
    assert "rod" in refused(wrong, with_thinner_rod(model, "test")[0]).message


def test_a_reversed_test_valve_is_named_with_its_channel(runs, model):
    error = refused(with_test_valve(runs, -1), model)
    assert "u_t_v" in error.message and "u_l" not in error.message
    assert "100 % of" in error.message and "scale: -1" in error.hint


def test_exchanged_load_valves_are_named_together(runs, model):
    exchanged = [replace(run, u_l1_v=run.u_l2_v, u_l2_v=run.u_l1_v) for run in runs]
    error = refused(exchanged, model)
    assert "u_l1_v" in error.message and "u_l2_v" in error.message
    assert "Exchange" in error.hint


def test_a_small_command_against_the_motion_may_be_a_null_and_a_larger_one_not(runs, model):
    refuse_contradictions(sessions(with_test_valve(runs, -0.05)), model)
    assert "u_t_v" in refused(with_test_valve(runs, -0.5), model).message


def test_a_command_that_holds_a_pressure_in_vain_is_no_wrong_sign(runs, model):
    """A transducer shows too much: the valve opens to the tank, the less the faster it fills."""
    one_way = [run for run in runs if run.plan.v_ref_m_s > 0]
    held = [replace(run, u_l1_v=-7.0 + run.u_l1_v) for run in one_way]
    refuse_contradictions(sessions(held), model)
    further = [replace(run, u_l1_v=-7.0 - run.u_l1_v) for run in one_way]
    assert "u_l1_v" in refused(further, model).message


def test_in_one_direction_friction_that_follows_a_pressure_is_no_other_area(model, runs):
    """Extending, friction of 10 % of the piston side's pressure force is like a smaller area.

    In both directions it has one sign, so it is an area.
    """
    tenth_m2 = 0.1 * model.par.test.area_piston_m2
    less = [replace(run, f_applied_n=run.f_applied_n - tenth_m2 * run.p_tp_pa) for run in runs]
    refuse_contradictions(sessions([run for run in less if run.plan.v_ref_m_s > 0]), model)
    assert refused(less, model).message.startswith("test_cylinder: ")


def test_pressures_that_differ_between_the_directions_alone_do_not_tell_the_areas(model):
    """As in a Stribeck schedule: 20 bar extending and 60 bar retracting.

    They rise by 2 bar with the speed, and extending has 60 N that grow with the speed's square.
    """
    usual = []
    for run in strokes(model, wander=0.0):
        v = run.plan.v_ref_m_s
        if (v > 0) == (run.p_tr_pa.mean() < 40 * BAR):
            more_pa, friction_n = 2 * BAR * (v / 0.12) ** 2, 60 * (max(v, 0.0) / 0.12) ** 2
            force = run.f_applied_n - more_pa * model.par.test.area_rod_m2 - friction_n
            usual.append(replace(run, p_tr_pa=run.p_tr_pa + more_pa, f_applied_n=force))
    refuse_contradictions(sessions(usual), model)
    thinner, _ = with_thinner_rod(model, "test")
    refuse_contradictions(sessions(usual), thinner)
    refused(strokes(model, wander=0.0), thinner)


@pytest.mark.parametrize("name, part", [("test_cylinder", "test"), ("load_cylinder", "load")])
def test_a_wrong_rod_in_the_model_is_refused_with_the_rod_that_would_fit(runs, model, name, part):
    thinner, rod_m = with_thinner_rod(model, part)
    error = refused(runs, thinner)
    assert error.message.startswith(f"{name}: ") and "limit: 8 %" in error.message
    found = float(error.message.split(" a rod of ")[1].split(" mm")[0])
    assert found == pytest.approx(1e3 * rod_m, abs=0.3)


def test_areas_that_the_campaign_states_otherwise_are_refused(runs, model):
    """Before commands: with another bore, their scale seems to be wrong."""
    own, halved = model.par.test, replace(model, par=with_half_the_bores(model.par))

    def stated(piston_m2, rod_m2):
        cylinder = Specimen(piston_m2, rod_m2)
        return [replace(run, plan=replace(run.plan, specimen=cylinder)) for run in runs]

    areas = own.area_piston_m2, own.area_rod_m2
    refuse_contradictions(sessions(stated(1.01 * areas[0], 0.99 * areas[1])), model)
    assert "valve.gain" in refused(runs, halved).hint
    bore = np.sqrt(4 * own.area_piston_m2 / np.pi)
    error = refused(stated(*areas), halved)
    assert error.message.startswith("test_cylinder: areas of ")
    assert f"(bore {500 * bore:.4g} mm," in error.message.split(" in the model file, ")[0]
    assert f"(bore {1e3 * bore:.4g} mm," in error.message.split(" in the model file, ")[1]
    rod = areas[0] - areas[1]  # its own area instead of the ring around it
    assert "ring: piston less rod" in refused(stated(areas[0], rod), model).hint


def with_half_the_bores(par):
    quarter = {
        part: getattr(par, part)._replace(
            area_piston_m2=getattr(par, part).area_piston_m2 / 4,
            area_rod_m2=getattr(par, part).area_rod_m2 / 4,
        )
        for part in ("test", "load")
    }
    return par._replace(**quarter)


def test_areas_are_not_judged_by_forces_that_no_area_explains(runs, model):
    """Points have 600 N more or less, alike in each of ten trials: 9 % by the least squares."""
    signs = np.random.default_rng(8).choice([-1, 1], len(runs))
    pushed = [
        replace(run, f_applied_n=run.f_applied_n + 600 * sign)
        for run, sign in zip(10 * runs, np.tile(signs, 10), strict=True)
    ]
    refuse_contradictions(sessions(pushed), model)
    refused(10 * runs, with_thinner_rod(model, "test")[0])


def test_logs_without_load_cylinder_or_force_sensor_are_not_refused(runs, model):
    alone = [
        replace(run, p_lp_pa=None, p_lr_pa=None, u_l1_v=None, u_l2_v=None, f_applied_n=0 * run.t_s)
        for run in runs
    ]
    refuse_contradictions(sessions(alone), model)
    assert "u_t_v" in refused(with_test_valve(alone, -1), model).message


def triangles(model):
    """The strokes of ``strokes``, with a velocity that rises and falls by half of itself."""
    swinging = []
    for run in strokes(model, wander=0.0):
        v, t = run.plan.v_ref_m_s, run.t_s
        more = 0.5 * v * (2 * np.abs((t / 0.75) % 2 - 1) - 1)
        x = run.x_m + np.cumsum(more) * 0.01
        swinging.append(replace(run, x_m=x, u_t_v=12 * (v + more), u_l1_v=9 * (v + more)))
    return swinging


def test_faults_are_refused_without_a_window_of_steady_motion(model):
    swinging = triangles(model)
    refuse_contradictions(sessions(swinging), model)
    error = refused([replace(run, u_t_v=-run.u_t_v) for run in swinging], model)
    assert error.message.startswith("u_t_v: valve T is commanded against the motion")


def test_exchanged_pressures_and_a_turned_force_are_told_apart(runs, model):
    error = refused([replace(run, p_tp_pa=run.p_tr_pa, p_tr_pa=run.p_tp_pa) for run in runs], model)
    assert error.message.startswith("test_cylinder: the force falls where p_tp_pa rises")
    assert error.hint.startswith("Exchange the columns of p_tp_pa and p_tr_pa")
    error = refused([replace(run, f_applied_n=-run.f_applied_n) for run in runs], model)
    assert "f_applied_n scale: -1" in error.hint


def test_a_position_that_counts_from_the_other_end_is_refused(runs, model):
    turned = [replace(run, x_m=model.par.test.stroke_m - run.x_m) for run in runs]
    error = refused(turned, model)
    assert error.message.startswith("u_t_v: valve T is commanded against the motion")
    assert error.hint.startswith("x_m is 0 at the retracted end")
    commands = ("u_t_v", "u_l1_v", "u_l2_v")
    both = [replace(run, **{name: -getattr(run, name) for name in commands}) for run in turned]
    error = refused(both, model)
    assert error.message.startswith("friction of both cylinders has the direction of the motion")
    assert error.hint.startswith("x_m is 0 at the retracted end")


def test_pressures_of_the_other_cylinder_are_refused_with_their_exchange(runs, model):
    exchanged = [
        replace(
            run, p_tp_pa=run.p_lp_pa, p_tr_pa=run.p_lr_pa, p_lp_pa=run.p_tp_pa, p_lr_pa=run.p_tr_pa
        )
        for run in runs
    ]
    error = refused(exchanged, model)
    assert error.message.startswith("friction of both cylinders has the direction of the motion")
    assert "exchange the pressures of both cylinders" in error.hint
    assert "p_tp_pa with p_lp_pa" in error.hint


def test_a_command_of_another_scale_is_refused_and_a_wrong_guess_of_the_gain_is_not(runs, model):
    moving = moving_windows(sessions(runs), model)
    share = np.median(moving.by_law_m3_s[:2] / moving.needed_m3_s[:2])
    fitting = with_test_valve(runs, 1 / share)
    for factor in (0.5, 1.0, 2.0):
        refuse_contradictions(sessions(with_test_valve(fitting, factor)), model)
    for factor, said in ((0.1, "0.1 times"), (10.0, "10 times")):
        limit = model.par.valve._replace(limit_v=100.0)
        error = refused(
            with_test_valve(fitting, factor), replace(model, par=model.par._replace(valve=limit))
        )
        assert error.message.startswith("u_t_v: the flows of valve T") and said in error.message
        assert "scale of u_t_v" in error.hint and "valve.gain" in error.hint


def test_commands_beyond_the_limit_of_their_valve_are_refused(runs, model):
    in_ma = [replace(run, u_l2_v=20 + 0.8 * run.u_l2_v) for run in runs]
    error = refused(in_ma, model)
    assert error.message.startswith("u_l2_v: 20") and "limit of the valve: 10 V" in error.message
    assert "unit" in error.hint
    limited = [replace(run, u_l2_v=np.where(run.t_s < 0.4, 20.0, run.u_l2_v)) for run in runs]
    refuse_contradictions(sessions(limited), model)


def test_a_force_of_another_unit_is_refused(runs, model):
    in_lbf = [replace(run, f_applied_n=run.f_applied_n / 4.448) for run in runs]
    error = refused(in_lbf, model)
    assert error.message.startswith("test_cylinder: f_applied_n is 0.2")
    assert "unit or scale of f_applied_n" in error.hint


@pytest.mark.parametrize("part", ["test", "load"])
def test_a_cylinder_of_the_next_preferred_bore_is_refused_with_the_bore_that_fits(
    runs, model, part
):
    """50 mm in the place of 40 mm, with a rod in proportion: the ratio of the areas is right."""
    own = getattr(model.par, part)
    larger = own._replace(
        area_piston_m2=1.25**2 * own.area_piston_m2, area_rod_m2=1.25**2 * own.area_rod_m2
    )
    error = refused(runs, replace(model, par=model.par._replace(**{part: larger})))
    assert error.message.startswith(f"{part}_cylinder: f_applied_n is 0.6")
    bore_mm = 1e3 * np.sqrt(4 * own.area_piston_m2 / np.pi)
    said = float(error.hint.split("a bore of ")[1].split(" mm")[0])
    assert said == pytest.approx(bore_mm, rel=0.02)
    assert "unit or scale of f_applied_n" in error.hint


@pytest.mark.parametrize("part", ["test", "load"])
@pytest.mark.parametrize("factor", [0.95, 1.05])
def test_a_bore_that_is_a_little_off_is_refused_also_with_a_wrong_load_cell(
    runs, model, part, factor
):
    """The rod is right, so the rod side's area is off by more. The cell shows 3 % more or less."""
    own = getattr(model.par, part)
    more_m2 = (factor**2 - 1) * own.area_piston_m2
    wrong = own._replace(
        area_piston_m2=own.area_piston_m2 + more_m2, area_rod_m2=own.area_rod_m2 + more_m2
    )
    off = replace(model, par=model.par._replace(**{part: wrong}))
    bore_mm = 1e3 * np.sqrt(4 * own.area_piston_m2 / np.pi)
    for gain in (0.97, 1.0, 1.03):
        shown = [replace(run, f_applied_n=gain * run.f_applied_n) for run in runs]
        error = refused(shown, off)
        assert error.message.startswith(f"{part}_cylinder: pressures and force give areas of ")
        said = float(error.hint.split("a bore of ")[1].split(" mm")[0])
        assert said == pytest.approx(bore_mm, rel=0.02)


def test_a_load_cell_that_shows_a_fifth_more_is_left_to_the_search(runs, model):
    refuse_contradictions(
        sessions([replace(run, f_applied_n=1.2 * run.f_applied_n) for run in runs]), model
    )


def test_another_supply_pressure_is_refused(runs, model):
    error = refused([replace(run, p_s_pa=1.4 * run.p_s_pa) for run in runs], model)
    assert error.message.startswith("p_s_pa: 210 bar in the median, supply.pressure")
    refuse_contradictions(sessions([replace(run, p_s_pa=0.85 * run.p_s_pa) for run in runs]), model)
    refuse_contradictions(sessions([replace(run, p_s_pa=None) for run in runs]), model)


def test_positions_outside_the_stroke_are_refused(runs, model):
    longer = [replace(run, x_m=3 * run.x_m) for run in runs]
    error = refused(longer, model)
    assert error.message.startswith("x_m: positions from") and "stroke" in error.message
    assert "offset" in error.hint


def test_a_stroke_that_the_campaign_states_otherwise_is_refused(runs, model):
    stated = [
        replace(run, plan=replace(run.plan, specimen=replace(NO_AREAS, stroke_m=0.4)))
        for run in runs
    ]
    refuse_contradictions(sessions(stated), model)
    test = model.par.test._replace(stroke_m=4.0)
    error = refused(stated, replace(model, par=model.par._replace(test=test)))
    assert error.message.startswith("test_cylinder.stroke: 4000 mm in the model file, 400 mm")

"""Each reason is given beyond its limit, and not just inside it."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.screening.screen import CODES, screen
from hbench.records import Specimen


def codes(screened):
    return [reason.split(":")[0] for reason in screened.reasons]


def marked(run, flags, start_s, stop_s):
    """Return the run with a flag set between two times."""
    return replace(run, **{flags: (run.t_s > start_s) & (run.t_s < stop_s)})


def without(run, lost):
    """Return the run without some of its samples."""
    kept = ~lost
    names = [name for name, value in vars(run).items() if isinstance(value, np.ndarray)]
    return replace(run, **{name: getattr(run, name)[kept] for name in names})


# ---- clean runs ----------------------------------------------------------------------------------


@pytest.mark.parametrize("direction", [1, -1])
def test_means_of_an_exact_run_are_its_closed_form(make_run, rules, direction):
    run = make_run(v_m_s=direction * 0.05, friction_n=400, f_applied_n=2000, p_tr_pa=20e5)
    means = screen(run, rules).means
    assert means.v_m_s == pytest.approx(direction * 0.05, rel=1e-9)
    assert means.friction_n == pytest.approx(direction * 400, rel=1e-9)
    assert means.f_test_n == pytest.approx(2000 + direction * 400, rel=1e-9)
    assert means.f_applied_n == pytest.approx(2000, rel=1e-9)
    assert means.p_tp_pa == pytest.approx((2000 + direction * 400 + 1500) / 1.25e-3, rel=1e-9)
    assert means.p_tr_pa == pytest.approx(20e5, rel=1e-9)


def test_the_window_waits_for_time_and_for_travel(make_run, rules):
    fast, slow = make_run(v_m_s=0.1), make_run(v_m_s=0.01, duration_s=3)
    # At the reference from the record at 0.105 s on; then 0.3 s, or 10 mm at 10 mm/s.
    assert screen(fast, rules).means.t_start_s == pytest.approx(0.405)
    assert screen(slow, rules).means.t_start_s == pytest.approx(1.105)
    assert screen(fast, rules).means.t_stop_s == pytest.approx(1.995)


@pytest.mark.parametrize("noise", [1.0, 5.0])
@pytest.mark.parametrize("speed", [0.005, 0.05, -0.15, -0.19])
def test_noisy_steady_runs_are_accepted_in_more_than_99_of_100(make_run, rules, speed, noise):
    duration = 3.6 if abs(speed) < 0.01 else 1.6
    runs = [
        make_run(v_m_s=speed, duration_s=duration, noise=noise, seed=seed) for seed in range(150)
    ]
    assert np.mean([not screen(run, rules).accepted for run in runs]) < 0.01


# ---- off the reference ---------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    ("v_ref", "limit"),
    [
        (0.005, 0.0005),  # absolute
        (0.050, 0.0015),  # 3 %
        (0.150, 0.0045),  # 3 %: the source's limit holds above
        (0.151, 0.0020),  # the source's
    ],
)
def test_off_reference_from_its_limit_on(make_run, rules, v_ref, limit, sign):
    duration = 4.0 if v_ref < 0.01 else 1.6
    for part, rejected in ((0.98, False), (1.02, True), (-0.98, False), (-1.02, True)):
        v = sign * (v_ref + part * limit)
        run = make_run(v_m_s=v, v_ref_m_s=sign * v_ref, duration_s=duration)
        assert ("off_reference" in codes(screen(run, rules))) == rejected


# ---- where the piston is -------------------------------------------------------------------------


@pytest.mark.parametrize(("distance_m", "rejected"), [(0.0021, False), (0.0019, True)])
@pytest.mark.parametrize("direction", [1, -1])
def test_end_stop_within_its_margin(make_run, rules, direction, distance_m, rejected):
    run = make_run(v_m_s=direction * 0.1)
    last = 0.4 - distance_m if direction > 0 else distance_m
    run = replace(run, x_m=run.x_m + last - run.x_m[-1])
    assert ("end_stop" in codes(screen(run, rules))) == rejected


def test_an_end_stop_of_unknown_place_is_not_looked_for(make_run, rules):
    run = make_run()
    foreign = replace(
        run,
        plan=replace(run.plan, specimen=Specimen(1.25e-3, 0.75e-3, None)),
        x_m=run.x_m - 0.05,
        at_reference=None,
    )
    assert screen(foreign, rules).accepted


@pytest.mark.parametrize(("standing_s", "rejected"), [(0.05, False), (0.5, True)])
def test_a_piston_that_rests_within_the_stroke_while_the_reference_moves_on_is_stalled(
    make_run, rules, standing_s, rejected
):
    run = make_run(v_m_s=0.1, wobble=lambda t: np.where(t > 2.0 - standing_s, -0.1, 0))
    screened = screen(run, rules)
    assert ("stalled" in codes(screened)) == rejected
    assert "end_stop" not in codes(screened)  # the stroke is 400 mm
    if rejected:
        rests = f"stalled: the piston rests at {1e3 * run.x_m[-1]:.1f} mm"
        assert any(reason.startswith(rests) for reason in screened.reasons)


def test_stick_slip_is_not_steady_and_not_a_stop(make_run, rules):
    def stick_slip(t):
        return np.where((t > 0.5) & (t % 0.6 > 0.3), -0.01, 0.01 * (t > 0.5))

    run = make_run(v_m_s=0.01, duration_s=4.2, wobble=stick_slip)
    found = codes(screen(run, rules))
    assert "not_steady" in found and not {"end_stop", "stalled"} & set(found)


# ---- steadiness ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("part", "rejected"), [(0.93, False), (1.07, True)])
@pytest.mark.parametrize(("v", "limit"), [(0.02, 0.002), (0.1, 0.005)])
def test_speed_ripple_from_its_limit_on(make_run, rules, v, limit, part, rejected):
    amplitude = part * limit * np.sqrt(2) / np.sinc(0.1) ** 2
    run = make_run(v_m_s=v, duration_s=3.6, wobble=lambda t: amplitude * np.sin(2 * np.pi * t))
    # Whole periods, so that the mean is the reference's.
    run = marked(run, "at_reference", 0.1, 3.6 if v > 0.05 else 3.1)
    assert codes(screen(run, rules)) == (["not_steady"] if rejected else [])


@pytest.mark.parametrize("seed", range(20))
def test_a_position_sensor_as_noisy_as_the_ripple_limit_does_not_look_unsteady(
    make_run, rules, seed
):
    run = make_run(v_m_s=0.02)
    noise = 6e-4 * np.random.default_rng(seed).standard_normal(len(run.x_m))
    # 0.1 s means of ten samples: sqrt(2/10) 0.6 mm / 0.1 s = 2.7 mm/s; the limit is 2 mm/s.
    assert "not_steady" not in codes(screen(replace(run, x_m=run.x_m + noise), rules))


@pytest.mark.parametrize(("drift_n", "rejected"), [(39, False), (41, True), (-39, False)])
def test_friction_drift_from_its_absolute_limit_on(make_run, rules, drift_n, rejected):
    # The window is 1.59 s long and begins at 0.405 s.
    run = make_run(v_m_s=0.1, friction_n=300, drift_n=lambda t: drift_n * (t - 1.2) / 1.59)
    assert codes(screen(run, rules)) == (["not_steady"] if rejected else [])


@pytest.mark.parametrize(("drift_n", "rejected"), [(78, False), (82, True)])
def test_friction_drift_from_its_relative_limit_on(make_run, rules, drift_n, rejected):
    run = make_run(v_m_s=0.1, friction_n=800, drift_n=lambda t: drift_n * (t - 1.2) / 1.59)
    assert codes(screen(run, rules)) == (["not_steady"] if rejected else [])


@pytest.mark.parametrize("records", range(180, 200))
def test_hum_is_no_drift_of_friction(make_run, rules, records):
    """Samples half a window apart differ by one of few values, and so does their median."""
    run = make_run(
        v_m_s=0.1,
        friction_n=300,
        noise=0.05,
        duration_s=records / 100,
        drift_n=lambda t: 250 * np.sin(2 * np.pi * 25 * t),
    )
    assert codes(screen(run, rules)) == []


@pytest.mark.parametrize(("dropouts", "rejected"), [(0, False), (1, False), (2, True)])
def test_dropouts_of_a_pressure_that_change_mean_friction_are_not_steady(
    make_run, rules, dropouts, rejected
):
    """One of 160 samples at 0 bar takes F_T / 160 = 24 N from the mean; the limit is 40 N."""
    run = make_run(v_m_s=0.1, noise=1.0)
    p_tp = run.p_tp_pa.copy()
    p_tp[np.arange(100, 100 + 10 * dropouts, 10)] = 0.0
    screened = screen(replace(run, p_tp_pa=p_tp), rules)
    assert codes(screened) == (["not_steady"] if rejected else [])
    if rejected:
        assert (
            "2 of 160 samples are far from all others and change mean friction" in screened.reason
        )


@pytest.mark.parametrize("bar", [0, 400])
@pytest.mark.parametrize(("spacing", "length"), [(12, 1), (12, 4), (4, 1)])
def test_a_pressure_that_drops_out_in_many_samples_is_not_steady(
    make_run, rules, bar, spacing, length
):
    run = make_run(v_m_s=0.1, noise=1.0)
    p_tp = run.p_tp_pa.copy()
    p_tp[np.arange(len(p_tp)) % spacing < length] = bar * 1e5
    (reason,) = screen(replace(run, p_tp_pa=p_tp), rules).reasons
    assert "samples are far from all others and change mean friction" in reason


def test_steps_of_a_coarse_pressure_are_no_dropouts(make_run, rules):
    """A quarter of the samples differ by one count of 1.5 bar, or 190 N; they are averaged."""
    run = make_run(v_m_s=0.1, noise=0.1)
    count = np.arange(len(run.p_tp_pa)) % 4 == 0
    p_tp = np.where(count, run.p_tp_pa.mean() + 1.5e5, run.p_tp_pa.mean())
    assert codes(screen(replace(run, p_tp_pa=p_tp), rules)) == []


def test_slips_after_which_friction_rises_gradually_are_no_dropouts(make_run, rules):
    """Each tenth of a second friction falls by 600 N, and rises again in 30 ms."""
    run = make_run(v_m_s=0.1, noise=1.0)
    after_s = np.mod(run.t_s, 0.1)
    fall_n = 600 * np.clip(1 - after_s / 0.03, 0, 1)
    falling = replace(run, p_tp_pa=run.p_tp_pa - fall_n / run.plan.specimen.area_piston_m2)
    assert codes(screen(falling, rules)) == []


# ---- the log -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("code", "why"), [("aborted", "heartbeat"), ("truncated", "record 17")])
def test_a_truncated_and_an_aborted_run_have_their_cause_as_reason(make_run, rules, code, why):
    assert screen(make_run(**{code: why}), rules).reasons == (f"{code}: {why}",)


def test_a_record_missing_in_the_window_is_a_gap_and_before_it_a_note(make_run, rules):
    run = make_run()
    inside = without(replace(run, missing_records=1), np.abs(run.t_s - 1.0) < 0.006)
    before = without(replace(run, missing_records=2), np.abs(run.t_s - 0.1) < 0.01)
    assert codes(screen(inside, rules)) == ["gapped"]
    assert screen(before, rules).accepted
    assert screen(before, rules).notes[0].startswith("2 records ")


@pytest.mark.parametrize(("gap_s", "rejected"), [(0.09, False), (0.12, True)])
def test_a_foreign_gap_from_its_limit_on(make_run, rules, gap_s, rejected):
    run = make_run()
    lost = (run.t_s > 1) & (run.t_s < 1 + gap_s - 0.01)
    foreign = replace(without(run, lost), at_reference=None)
    assert np.diff(foreign.t_s).max() == pytest.approx(gap_s)
    assert ("gapped" in codes(screen(foreign, rules))) == rejected


def test_a_log_that_samples_slowly_has_its_rate_and_the_key_of_the_limit_as_reason(make_run, rules):
    run = make_run()
    slow = replace(without(run, np.arange(len(run.t_s)) % 20 != 0), at_reference=None)
    (reason,) = (each for each in screen(slow, rules).reasons if each.startswith("gapped"))
    assert reason.endswith("has a sample every 0.20 s; limit 0.1 s (screening.max_gap)")


@pytest.mark.parametrize("code", ["sensor_saturated", "valve_saturated"])
def test_saturation_counts_within_the_window(make_run, rules, code):
    run = make_run(v_m_s=0.1)  # window from 0.405 s
    assert codes(screen(marked(run, code, 1.0, 1.01), rules)) == [code]
    assert screen(marked(run, code, 0.0, 0.40), rules).accepted


def test_the_reason_names_the_valve_at_its_limit(make_run, rules):
    run = marked(make_run(v_m_s=0.1), "valve_saturated", 1.0, 1.1)
    at_limit = np.where(run.valve_saturated, -10.0, 3.0 + np.sin(run.t_s))
    run = replace(run, u_t_v=5.0 + np.cos(run.t_s), u_l1_v=at_limit, u_l2_v=0 * run.t_s)
    (reason,) = screen(run, rules).reasons
    assert reason.startswith("valve_saturated: u_L1 is at its minimum, -10.0 V, in ")
    assert reason.endswith(" records of the window (none allowed)")


@pytest.mark.parametrize(("stop_s", "rejected"), [(0.711, False), (0.689, True)])
def test_too_short_a_window(make_run, rules, stop_s, rejected):
    run = marked(make_run(v_m_s=0.1), "at_reference", 0.1, stop_s)
    screened = screen(run, rules)
    assert codes(screened) == (["too_short"] if rejected else [])
    assert (screened.means is None) == rejected


def test_a_reference_that_was_never_reached_is_too_short(make_run, rules):
    run = marked(make_run(), "at_reference", 9, 9)
    assert "never reached" in screen(run, rules).reasons[0]


@pytest.mark.parametrize("channel", ["p_tp_pa", "p_tr_pa", "f_applied_n"])
def test_friction_needs_three_channels(make_run, rules, channel):
    screened = screen(replace(make_run(), **{channel: None}), rules)
    assert codes(screened) == ["missing_channel"]
    assert channel in screened.reasons[0]
    assert screened.means.friction_n is None


def test_a_cylinder_without_rod_side_needs_no_rod_pressure(make_run, rules):
    run = make_run(v_m_s=0.1, p_tr_pa=0.0)
    plunger = replace(run, p_tr_pa=None, plan=replace(run.plan, specimen=Specimen(1.25e-3, 0.0)))
    assert screen(plunger, rules).means.friction_n == pytest.approx(400)


def test_samples_without_value_are_left_out_and_told(make_run, rules):
    run = make_run()
    run.f_applied_n[100:103] = np.nan
    screened = screen(run, rules)
    assert screened.accepted
    assert "3 of 200 samples" in screened.notes[0]
    run.f_applied_n[100:120] = np.nan
    assert codes(screen(replace(run, at_reference=None), rules)) == ["gapped"]


@pytest.mark.parametrize("channel", ["p_s_pa", "v_m_s", "u_l2_v", "p_lr_pa"])
def test_an_empty_optional_channel_is_one_that_was_not_measured(make_run, rules, channel):
    run = make_run()
    bare = screen(run, rules)
    screened = screen(replace(run, **{channel: np.full(len(run.t_s), np.nan)}), rules)
    assert screened.accepted and screened.means == bare.means
    assert getattr(screened.run, channel) is None
    (note,) = screened.notes
    assert note.startswith(f"{channel} ")


@pytest.mark.parametrize("channel", ["p_s_pa", "v_m_s"])
def test_a_gap_in_an_optional_channel_drops_no_sample(make_run, rules, channel):
    run = make_run(v_m_s=0.1)
    values = np.full(len(run.t_s), 0.1)
    values[100:150] = np.nan
    screened = screen(replace(run, **{channel: values}), rules)
    assert screened.accepted and not screened.notes
    assert screened.means == screen(run, rules).means
    # What is known of the controller's velocity is still judged.
    values[50:100:2] = 0.2
    found = codes(screen(replace(run, **{channel: values}), rules))
    assert found == (["not_steady"] if channel == "v_m_s" else [])


def test_an_empty_needed_channel_is_missing(make_run, rules):
    run = make_run()
    screened = screen(replace(run, f_applied_n=np.full(len(run.t_s), np.nan)), rules)
    assert codes(screened) == ["missing_channel"]
    assert len(screened.run.t_s) == len(run.t_s)


def test_a_plunger_does_not_mind_gaps_of_a_rod_pressure_that_it_has_no_area_for(make_run, rules):
    run = make_run(v_m_s=0.1, p_tr_pa=0.0)
    plunger = replace(run, plan=replace(run.plan, specimen=Specimen(1.25e-3, 0.0)))
    plunger.p_tr_pa[60:160] = np.nan
    means = screen(plunger, rules).means
    assert means.friction_n == pytest.approx(400) and means.n == 160
    assert means.p_tr_pa is None


@pytest.mark.parametrize("foreign", [True, False])
def test_an_empty_log_is_rejected_and_raises_nothing(make_run, rules, foreign):
    run = make_run(truncated="the log holds no record")
    empty = without(run, np.ones(len(run.t_s), dtype=bool))
    empty = replace(empty, at_reference=None if foreign else empty.at_reference)
    assert codes(screen(empty, rules)) == ["truncated", "too_short"]


def test_each_kind_of_fault_of_a_log_is_a_reason_with_its_code_once(make_run, rules):
    faults = "no last record; changed: other bytes; truncated: 5 of 9 records; and a cut word"
    found = screen(make_run(truncated=faults), rules).reasons
    assert found[:2] == (
        "truncated: no last record; 5 of 9 records; and a cut word",
        "changed: other bytes",
    )
    run = make_run(truncated="changed: not the bytes that were written")
    assert screen(run, rules).reasons[0] == "changed: not the bytes that were written"


def test_an_aborted_run_is_not_rejected_for_its_short_log_too(make_run, rules):
    run = make_run(aborted="interrupted by the operator", truncated="no last record; changed: x")
    assert codes(screen(run, rules)) == ["aborted", "changed"]
    empty = without(run, np.ones(len(run.t_s), dtype=bool))
    assert codes(screen(empty, rules)) == ["aborted", "changed"]
    whole = make_run(aborted="fault: travel", valve_saturated=np.ones(200, dtype=bool))
    assert codes(screen(whole, rules)) == ["aborted", "valve_saturated"]


def test_all_reasons_are_given_the_most_fundamental_first(make_run, rules):
    run = make_run(
        v_m_s=0.1,
        v_ref_m_s=0.2,
        truncated="no last record",
        valve_saturated=np.ones(200, dtype=bool),
        drift_n=lambda t: 200 * t,
    )
    found = codes(screen(run, rules))
    assert found == ["truncated", "valve_saturated", "off_reference", "not_steady"]
    assert found == sorted(found, key=CODES.index)


# ---- another bench's strokes ---------------------------------------------------------------------


@pytest.mark.parametrize("direction", [1, -1])
def test_a_stroke_without_reference_is_cut_at_both_ends(make_run, rules, direction):
    v = direction * 0.02

    def ends(t):
        return np.where(t < 0.5, v * (t / 0.5 - np.minimum(t / 0.1, 1)), 0) - np.where(
            t > 2.5, v * np.minimum((t - 2.5) / 0.5, 1), 0
        )

    run = make_run(v_m_s=v, duration_s=3.0, wobble=ends, noise=1.0)
    screened = screen(replace(run, at_reference=None), rules)
    assert screened.accepted
    assert screened.means.v_m_s == pytest.approx(v, rel=5e-3)
    assert 0.8 < screened.means.t_start_s < 1.2
    assert 2.4 < screened.means.t_stop_s < 2.6

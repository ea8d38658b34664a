"""Raw logs to SI, against numbers worked out by hand from appendices B and C."""

import re
from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.curves.average import curves
from hbench.analysis.screening.calibrate import calibrate
from hbench.analysis.screening.screen import screen
from hbench.config.schedule import Screening
from hbench.config.sensors import TemperatureSensor
from hbench.errors import DataError
from hbench.records import LogChannel, RawRun, RunPlan, Specimen

CHANNELS = (
    LogChannel("run", False, 1, "1"),
    LogChannel("index", False, 1, "1"),
    LogChannel("flags", False, 1, "1"),
    LogChannel("x", False, 1 / 16, "count"),
    LogChannel("p_tp", False, 1 / 16, "count"),
    LogChannel("f_applied", False, 1 / 16, "count"),
    LogChannel("v", True, 1e-5, "m/s"),
    LogChannel("u_t", True, 1e-3, "V"),
)
FLAGS = ("at_reference", "sensor_saturated", "valve_saturated", "last")
PLAN = RunPlan("0007", "steady", 1, 0.05, Specimen(1.25e-3, 0.75e-3, 0.4))


def raw(n=6, **changes):
    words = np.zeros((n, len(CHANNELS)), dtype=np.uint16)
    words[:, 0] = 7
    words[:, 1] = np.arange(n)
    words[:, 3:6] = 2048 * 16
    words[-1:, 2] = 0b1000
    values = {"plan": PLAN, "words": words, "channels": CHANNELS, "flags": FLAGS}
    return RawRun(**{**values, "rate_hz": 100.0, "outcome": "done", **changes})


def test_half_scale_of_the_pressure_channel_is_118_67_bar(bench):
    # 2048 counts = 1.5 V; 3.16 V at the converter = 10 V at the transducer = 250 bar.
    run = calibrate(raw(), bench)
    np.testing.assert_allclose(run.p_tp_pa, 1.5 / 3.16 * 250e5, rtol=1e-12)
    assert run.p_tp_pa[0] / 1e5 == pytest.approx(118.67, abs=0.005)


def test_half_scale_of_the_position_channel_is_213_6_mm(bench):
    np.testing.assert_allclose(calibrate(raw(), bench).x_m, 1.5 / 3.16 * 0.450, rtol=1e-12)


def test_half_scale_of_the_load_cell_is_no_force_and_each_volt_is_equation_c6(bench):
    # Level 1.5 V = 2048 counts. C.6: 4 A E / (2 u_s k (1 + nu) K) per volt.
    per_volt = 4 * 200e-6 * 210e9 / (2 * 10.46 * 2.1 * 1.3 * 360)
    log = raw()
    log.words[1, 5] = 16 * 3072  # 2.25 V
    force = calibrate(log, bench).f_applied_n
    assert force[0] == pytest.approx(0, abs=1e-9)
    assert force[1] == pytest.approx(0.75 * per_volt, rel=1e-12)


@pytest.fixture
def with_oil_sensor(bench):
    """0 to 100 degC are 0 to 3 V."""
    sensor = TemperatureSensor(span="100 K", lowest="0 degC", output="10 V", amplifier=0.3)
    sensors = bench.sensors.model_copy(update={"temperature": sensor})
    return bench.model_copy(update={"sensors": sensors})


def test_the_oil_temperature_is_read_where_the_bench_has_a_sensor(bench, with_oil_sensor):
    """At a limit of the converter there is no temperature, and the run is still good."""
    log = raw(channels=(*CHANNELS, LogChannel("temp_tank", False, 1 / 16, "count")))
    temps = np.array([[16 * 2048, 16 * 1024, 0, 16 * 4095, 16 * 2048, 16 * 2048]]).T
    log = replace(log, words=np.hstack([raw().words, temps.astype(np.uint16)]))
    run = calibrate(log, with_oil_sensor)
    expected = [323.15, 298.15, np.nan, np.nan, 323.15, 323.15]
    np.testing.assert_allclose(run.temp_tank_k, expected, rtol=1e-12)
    assert not run.sensor_saturated.any() and not run.truncated
    assert calibrate(log, bench).temp_tank_k is None
    assert calibrate(raw(), with_oil_sensor).temp_tank_k is None  # a board of before


def test_sixteenths_of_a_count_are_kept(bench):
    log = raw()
    log.words[1, 4] += 1
    step = np.diff(calibrate(log, bench).p_tp_pa)[0]
    assert step == pytest.approx(3 / 4096 / 16 / 3.16 * 250e5, rel=1e-6)


def test_signed_words_keep_their_sign(bench):
    log = raw()
    log.words[:, 6] = [0, 1, 0x7FFF, 0x8000, 0xFFFF, 5000]
    np.testing.assert_allclose(
        calibrate(log, bench).v_m_s, [0, 1e-5, 0.32767, -0.32768, -1e-5, 0.05]
    )


def test_flag_bits_go_to_their_names(bench):
    log = raw()
    log.words[:, 2] = [0b0000, 0b0001, 0b0010, 0b0100, 0b0011, 0b1101]
    run = calibrate(log, bench)
    assert run.at_reference.tolist() == [False, True, False, False, True, True]
    assert run.sensor_saturated.tolist() == [False, False, True, False, True, False]
    assert run.valve_saturated.tolist() == [False, False, False, True, False, True]
    assert not run.truncated


def test_a_record_stands_for_the_middle_of_its_interval(bench):
    np.testing.assert_allclose(calibrate(raw(3), bench).t_s, [0.005, 0.015, 0.025])


def test_the_index_runs_on_over_16_bits(bench):
    log = raw(70000)
    run = calibrate(log, bench)
    np.testing.assert_allclose(np.diff(run.t_s), 0.01, rtol=1e-6)
    assert run.missing_records == 0 and not run.truncated


@pytest.mark.parametrize(
    ("kept", "missing"), [([0, 1, 2, 3, 4, 5], 0), ([0, 1, 4, 5], 2), ([2, 3, 4, 5], 2)]
)
def test_missing_records_are_counted_and_leave_a_hole_in_time(bench, kept, missing):
    log = raw()
    run = calibrate(raw(words=log.words[kept]), bench)
    assert run.missing_records == missing
    np.testing.assert_allclose(run.t_s, (np.array(kept) + 0.5) / 100)


def test_a_whole_log_is_neither_truncated_nor_aborted(bench):
    run = calibrate(raw(warnings=("format: 9 leaves the notation open",)), bench)
    assert (run.truncated, run.aborted, run.missing_records) == ("", "", 0)


def test_a_log_without_its_last_record_is_truncated(bench):
    run = calibrate(raw(words=raw().words[:-1]), bench)
    assert re.search(r"\brecord 4\b", run.truncated)


def test_a_run_without_stop_part_is_unfinished(bench):
    assert calibrate(raw(outcome=None), bench).truncated.startswith("unfinished: ")


def test_a_run_that_hbench_left_has_no_other_reason_for_its_short_log(bench):
    """Its log is not lost, its motion not too short, and no log is to be restored."""
    left = raw(words=raw().words[:0], outcome=None, warnings=("missing: 0023.dat does not exist",))
    reasons = screen(calibrate(left, bench), Screening()).reasons
    codes = [reason.partition(":")[0] for reason in reasons]
    assert codes[0] == "unfinished" and not {"missing", "truncated", "too_short"} & set(codes)


def test_what_the_reader_said_of_a_cut_file_is_told(bench):
    warning = "truncated: the last line ('00') is cut off"
    assert warning in calibrate(raw(warnings=(warning,)), bench).truncated


def test_an_empty_log_is_truncated_and_has_no_samples(bench):
    run = calibrate(raw(words=raw().words[:0]), bench)
    assert "no record" in run.truncated
    assert len(run.t_s) == 0 and run.missing_records == 0


def test_an_aborted_run_keeps_its_cause(bench):
    run = calibrate(raw(outcome="aborted", why="fault: travel"), bench)
    assert run.aborted == "fault: travel"
    assert "failed" in calibrate(raw(outcome="failed"), bench).aborted


def test_records_of_another_run_are_left_out_and_told(bench):
    log = raw()
    log.words[:2, 0] = 6
    run = calibrate(log, bench)
    assert len(run.t_s) == 4
    assert "2 of 6 records" in run.truncated


@pytest.mark.parametrize("back", [2, 1, 0])
def test_records_out_of_order_are_left_out_and_told(bench, back):
    log = raw()
    log.words[:, 1] = [0, 1, 2, back, back + 1, back + 2]
    run = calibrate(log, bench)
    assert len(run.t_s) == 3
    assert re.search(rf"\brecord {back}\b.*\brecord 2\b.*\b3 records\b", run.truncated)


def test_unknown_channels_and_wrong_widths_are_refused(bench):
    strange = (*CHANNELS[:-1], LogChannel("oil_temperature", False, 1, "K"))
    with pytest.raises(DataError, match="oil_temperature"):
        calibrate(raw(channels=strange), bench)
    with pytest.raises(DataError, match="7 columns"):
        calibrate(raw(channels=CHANNELS[:-1]), bench)
    with pytest.raises(DataError, match="'index'"):
        calibrate(raw(channels=(CHANNELS[0], CHANNELS[0], *CHANNELS[2:])), bench)


@pytest.mark.parametrize(("p_bar", "flagged"), [(237.2, False), (237.3, True), (245.0, True)])
def test_a_pressure_above_9_49_of_10_v_is_flagged_whatever_the_board_says(bench, p_bar, flagged):
    # 10 V are 250 bar and 3.16 V at the converter, which ends at 4095 / 4096 of 3 V: 237.28 bar.
    counts = min(p_bar / 250 * 3.16 / 3 * 4096, 4095)
    log = raw()
    log.words[2:4, 4] = round(16 * counts)
    run = calibrate(log, bench)
    assert run.sensor_saturated.tolist() == [False, False, flagged, flagged, False, False]
    assert run.p_tp_pa.max() <= 237.29e5


def test_a_run_above_the_converters_end_is_rejected_and_not_averaged(bench, rules):
    log = raw(300)
    log.words[:, 2] = np.where(np.arange(300) == 299, 0b1001, 0b0001)
    log.words[:, 3] = 16 * (600 + 4.55 * np.arange(300))  # 50 mm/s
    log.words[:, 4] = 16 * np.minimum(4080 + 0.1 * np.arange(300), 4095)  # 236.4 to 238.1 bar
    supply = np.where(np.arange(300) % 50, 150e5, 149e5)  # its highest, marked or not
    quiet = {"p_tr_pa": np.full(300, 20e5), "p_s_pa": supply}
    screened = screen(replace(calibrate(log, bench), **quiet), rules)
    (reason,) = (r for r in screened.reasons if r.startswith("sensor_saturated"))
    assert re.search(r"P_Tp [^,;]*maximum, 237\.3 bar", reason)
    assert "P_S" not in reason
    assert curves([screened]) == ()


def test_a_sensor_at_its_end_in_the_whole_run_is_named_and_no_quiet_one_beside_it(bench, rules):
    log = raw(300)
    log.words[:, 2] = np.where(np.arange(300) == 299, 0b1001, 0b0001)
    log.words[:, 3] = 16 * (600 + 4.55 * np.arange(300))  # 50 mm/s
    log.words[:, 4] = 16 * (1000 + (np.arange(300) % 5 == 0))  # its lowest in four of five
    log.words[:, 5] = 16 * 4095  # (3 V * 4095/4096 - 1.5 V) of equation C.6
    screened = screen(replace(calibrate(log, bench), p_tr_pa=np.full(300, 20e5)), rules)
    (reason,) = (r for r in screened.reasons if r.startswith("sensor_saturated"))
    assert re.search(r"F_applied [^,;]*constant [^,;]*12251 N", reason)
    assert "P_Tp" not in reason


def test_a_load_cell_at_either_end_is_flagged(bench):
    log = raw()
    log.words[1, 5], log.words[4, 5] = 0, 16 * 4095
    flags = calibrate(log, bench).sensor_saturated
    assert flags.tolist() == [False, True, False, False, True, False]

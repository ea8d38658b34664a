"""Readings of an unknown logger that are late: filtered, or read one after another."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfilt, sosfilt_zi

from hbench.config.files.loading import read_yaml
from hbench.reconcile.diagnose import diagnose
from hbench.reconcile.measured.session import sessions
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.records import FitParameter
from hbench.report.diagnosis.verdict import verdict_words
from hbench.report.diagnosis.words.delay import delay_words
from tests.support import ROOT
from tests.support.reconcile.blind import MODEL, task_of
from tests.support.reconcile.few_candidates import try_only

SAMPLES = ROOT / "data_samples" / "blind"
COMMANDS = ("u_t_v", "u_l1_v", "u_l2_v")
FILTER_HZ = 10.0
FILTER_MS = 1e3 * np.sqrt(2) / (2 * np.pi * FILTER_HZ)  # delay at low frequencies


def filtered(run, name):
    """Return a run with a channel behind a Butterworth filter of second order."""
    y = getattr(run, name)
    sos = butter(2, FILTER_HZ, fs=1 / np.median(np.diff(run.t_s)), output="sos")
    return replace(run, **{name: sosfilt(sos, y, zi=y[0] * sosfilt_zi(sos))[0]})


def late(run, records, *names):
    """Return a run in which channels are late by some records."""
    found = {name: getattr(run, name) for name in names}
    held = {
        name: np.concatenate([np.full(records, y[0]), y[:-records]]) for name, y in found.items()
    }
    return replace(run, **held)


def diagnosed(campaign, change):
    """Return the diagnosis of a stored campaign as that of a bench whose board is unknown."""
    task = task_of(SAMPLES / campaign)
    runs, sections = tuple(map(change, task.runs)), read_yaml(MODEL)
    return diagnose(replace(task, bench=None, runs=runs, plant_data=sections))


def logged(run):
    """A load cell behind a filter, a pressure that is read a record later, commands two later."""
    return late(late(filtered(run, "f_applied_n"), 1, "p_tp_pa"), 2, *COMMANDS)


@pytest.fixture(scope="module")
def without_effect():
    """The diagnosis with the effects that are most like delays."""
    with pytest.MonkeyPatch.context() as patch:
        try_only(patch, "valve_lag", "friction_lag", "added_mass", "load_cell_gain")
        return diagnosed("none-5", logged)


@pytest.mark.slow
def test_late_channels_are_no_effect_of_the_whole_catalogue():
    assert diagnosed("none-5", logged).verdict == "none"


def test_a_filter_and_late_channels_are_no_effect(without_effect):
    assert without_effect.verdict == "none"
    for gap in without_effect.where:
        assert gap.deviation < gap.material, gap


def test_the_delays_are_those_of_the_filter_and_of_a_record(without_effect):
    delays = without_effect.delays
    print({name: (round(each.value, 2), each.se) for name, each in delays.items()})
    assert set(delays) == {"f_applied", "p_tp", "commands"}
    assert delays["f_applied"].value == pytest.approx(FILTER_MS, abs=1.5)
    assert delays["p_tp"].value == pytest.approx(10.0, abs=1.0)
    assert delays["commands"].value == pytest.approx(20.0, abs=2.0)


def test_the_first_paragraph_tells_which_readings_are_late(without_effect):
    words = verdict_words(without_effect)
    assert "Against the position these readings are late: P_Tp by " in words
    assert "the load cell by 2" in words and " and the valves' commands by " in words
    assert "taken into account" in words


@pytest.mark.slow
def test_a_late_position_is_no_lag_of_the_valves():
    """All sensors are early against it, and so are the valves: they seem to be late."""
    found = diagnosed("none-5", lambda run: late(run, 1, "x_m", "v_m_s"))
    assert found.verdict == "none"
    print({name: (round(each.value, 2), each.se) for name, each in found.delays.items()})
    assert found.delays["x"].value == pytest.approx(10.0, abs=1.0)
    assert "The position is late by " in verdict_words(found)


@pytest.mark.slow
def test_a_leak_is_named_behind_a_filter_of_the_load_cell():
    found = diagnosed("internal_leakage-clear-1", lambda run: filtered(run, "f_applied_n"))
    assert [each.name for each in found.effects] == ["internal_leakage"]
    assert found.delays["f_applied"].value == pytest.approx(FILTER_MS, abs=1.5)


def test_a_board_that_is_known_reads_all_channels_at_once():
    task = task_of(SAMPLES / "none-5")
    measured = MeasuredCampaign(task.bench, task.plant, None, sessions(task.runs), task.material)
    assert not any("delay" in name for name in measured.nuisance_columns)
    unknown = replace(measured, bench=None)
    assert "~delay_f_applied" in unknown.nuisance_columns


@pytest.mark.parametrize("delay_s", [-0.015, 0.004, 0.02])
def test_a_channel_ahead_is_the_signal_before_its_delay(delay_s):
    """Sinusoids of 3 Hz, in two runs; a Taylor series of two terms has an error of 1 %."""
    task = task_of(SAMPLES / "none-5")
    runs, wanted = [], []
    for phase, run in enumerate(task.runs[:2]):
        angle = 2 * np.pi * 3.0 * run.t_s + phase
        runs.append(replace(run, f_applied_n=np.sin(angle - 2 * np.pi * 3.0 * delay_s)))
        wanted.append(np.sin(angle)[3:-3])
    (session,) = sessions(runs)
    found = np.split(session.ahead("f_applied_n", delay_s), session.edges[1:-1])
    for ahead, expected in zip(found, wanted, strict=True):
        assert ahead[3:-3] == pytest.approx(expected, abs=0.02)


def test_early_readings_are_called_early(without_effect):
    early = FitParameter(-6.2, 0.3, (-6.8, -5.6), None, "ms")
    words = delay_words(replace(without_effect, delays={"p_lr": early}))
    assert "these readings are early: P_Lr by 6.20 +- 0.60 ms" in words.replace("\u00b1", "+-")
    assert delay_words(replace(without_effect, delays={})) == ""

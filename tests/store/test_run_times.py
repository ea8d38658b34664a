"""Start times of runs: wrong clocks of the computer, changes of zone, dates in foreign logs."""

from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest
import yaml

from hbench.store.campaign.folder import load_campaign
from hbench.store.campaign.writer import CampaignWriter
from hbench.store.importing.importer import import_folder
from hbench.store.importing.plausibility import LoggedSpan, at_the_same_time

NOON = datetime(2026, 10, 25, 0, 50, tzinfo=UTC)
SUMMER, WINTER = timezone(timedelta(hours=2)), timezone(timedelta(hours=1))


@pytest.fixture
def campaign_at(tmp_path, header, make_plan, words):
    """Return a function that writes a campaign with a run at each of some times, and loads it."""

    def write(*times):
        writer = CampaignWriter.create(tmp_path / "campaign", header)
        for number, time in enumerate(times, start=1):
            plan = make_plan(f"{number:04d}")
            writer.start_run(plan, time)
            writer.finish_run(plan, words, "done", "", time + timedelta(seconds=5))
        return load_campaign(tmp_path / "campaign")

    return write


def after(*seconds):
    return [NOON + timedelta(seconds=s) for s in seconds]


def test_a_clock_that_is_right_gives_the_start_times(campaign_at):
    campaign = campaign_at(*after(0, 20, 45))
    assert campaign.start_times_s() == {"0001": 0.0, "0002": 20.0, "0003": 45.0}
    assert campaign.warnings == ()


def test_the_end_of_summer_time_is_no_step_of_the_clock(campaign_at):
    first, second = after(0, 900)  # 02:50 in summer, 02:05 in winter
    campaign = campaign_at(first.astimezone(SUMMER), second.astimezone(WINTER))
    assert campaign.start_times_s() == {"0001": 0.0, "0002": 900.0}
    assert campaign.warnings == ()
    assert datetime.fromisoformat(campaign.provenance().stopped) == second + timedelta(seconds=5)


def test_a_clock_that_goes_back_leaves_the_order_alone_and_is_reported(campaign_at):
    campaign = campaign_at(*after(0, 20, -3560, -3530))
    assert campaign.start_times_s() == {}
    (warning,) = campaign.warnings
    assert "the clock of the computer went back by 3580 s from run 0002 to 0003" in warning


@pytest.mark.parametrize("unset", [0, 1])
def test_a_clock_that_was_not_set_leaves_the_order_alone_and_is_reported(campaign_at, unset):
    times = after(0, 20)
    times[unset] = datetime(1970, 1, 1, 0, 3, tzinfo=UTC)
    campaign = campaign_at(*times)
    assert campaign.start_times_s() == {}
    (warning,) = campaign.warnings
    assert f"was not set: run 000{unset + 1} has the date 1970-01-01" in warning


@pytest.mark.parametrize(
    ("stamps", "expected"),
    [  # of files 1 to 3, which are in the order of their names
        (
            ("2024-05-03 10:00:0{}", "2024-05-03 09:00:0{}", "03.05.2024 11:30:0{},0"),
            {"0001": 3600.0, "0002": 0.0, "0003": 9000.0},
        ),
        (("10:00:0{}", "09:00:0{}", "11:30:0{}"), {}),  # of unknown days
        (("1970-01-01 10:00:0{}", "2024-05-03 09:00:0{}", "2024-05-03 11:30:0{}"), {}),
        # a clock that begins at one date whenever it is switched on
        (("2020-01-01 00:00:0{}", "2020-01-01 00:00:0{}.5", "2020-01-01 00:01:0{}"), {}),
    ],
)
def test_dates_in_foreign_logs_are_the_start_times_of_their_runs(tmp_path, at, stamps, expected):
    assert starts_of(tmp_path, at, stamps) == expected


@pytest.mark.parametrize(("second_s", "noted"), [(10, False), (8, False), (2, True), (-3, True)])
def test_files_of_one_bench_that_were_logged_at_the_same_time_are_noted(second_s, noted):
    starts = {"1.csv": NOON, "2.csv": NOON + timedelta(seconds=second_s)}
    spans = [LoggedSpan(name, at, at + timedelta(seconds=10)) for name, at in starts.items()]
    note = at_the_same_time(spans)
    assert bool(note) == noted and all(name in note for name in starts if noted)


def test_times_of_day_are_on_the_date_that_the_map_states(tmp_path, at):
    stamps = "10:00:0{}", "9:00:0{}", "11:30:0{}"
    expected = {"0001": 3600.0, "0002": 0.0, "0003": 9000.0}
    for number, (date, known) in enumerate((("2024-05-03", expected), ("3 May", {}))):
        folder = tmp_path / str(number)
        folder.mkdir()
        assert starts_of(folder, at, stamps, {"date": date}) == known
    origins = {entry.origin["start"] for entry in load_campaign(tmp_path / "0/out").entries}
    assert "2024-05-03T09:00:00+00:00" in origins


def starts_of(tmp_path, at, stamps, test=None):
    """Return the start times of imported files whose first columns are ``stamps``."""
    (tmp_path / "logs").mkdir()
    for number, stamp in enumerate(stamps, start=1):
        rows = [f"{stamp.format(second)};{5 * second}" for second in range(6)]
        (tmp_path / f"logs/{number}.csv").write_text("\n".join(["t;x", *rows, ""]))
    rules = {
        "name": "dates",
        "format": {"separator": "semicolon"},
        "columns": {
            "t_s": {"column": "t", "unit": "date-time"},
            "x_m": {"column": "x", "unit": "mm"},
        },
        "series": [{"label": "", "files": "{trial}.csv", "cylinder": {"piston_diameter": "25 mm"}}],
        "test": test or {},
    }
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
    import_folder(tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", {}, at(0))
    return load_campaign(tmp_path / "out").start_times_s()


T = np.arange(0, 2, 0.01)
UNITS = {"x": "m", "p": "bar"}  # of the channels, which rise with time


def write_tdms(path, start):
    from nptdms import ChannelObject, TdmsWriter

    about = {"wf_increment": 0.01}
    if start is not None:
        about["wf_start_time"] = np.datetime64(start.replace(tzinfo=None))
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [
                ChannelObject("log", name, T, about | {"unit_string": unit})
                for name, unit in UNITS.items()
            ]
        )


def write_mdf(path, start):
    from asammdf import MDF, Signal

    with MDF(version="4.10" if path.suffix == ".mf4" else "3.30") as mdf:
        mdf.append([Signal(T, T, name=name, unit=unit) for name, unit in UNITS.items()])
        if start is None and path.suffix == ".mf4":
            mdf.header.abs_time = 0
        elif start is None:
            mdf.header.date = b"00:00:0000"
        else:
            mdf.header.start_time = start
        mdf.save(path, overwrite=True)


def write_twincat(path, start):
    ticks = start and (start - datetime(1601, 1, 1, tzinfo=UTC)) // timedelta(microseconds=1) * 10
    rows = (f"{1e3 * t:.0f},{t!r},{t!r}" for t in T.tolist())
    head = ["Name,Crane", f"Starttime of export,{ticks or ''},Wednesday"]
    path.write_text("\n".join([*head, "", "Name,x,p", "Unit,m,bar", "", *rows, ""]))


@pytest.mark.parametrize(
    ("ending", "write"),
    [("tdms", write_tdms), ("mf4", write_mdf), ("mdf", write_mdf), ("csv", write_twincat)],
)
@pytest.mark.parametrize("dated", [True, False])
def test_files_that_state_their_start_give_the_start_times_of_their_runs(
    tmp_path, at, ending, write, dated
):
    """Version 3 of MDF has whole seconds; a file without a date has no start, not the present."""
    (tmp_path / "logs").mkdir()
    for number, seconds in enumerate((3600, 0, 9000), start=1):
        write(tmp_path / f"logs/{number}.{ending}", at(seconds) if dated else None)
    rules = {
        "name": "dates",
        "columns": {
            "x_m": {"column": "x", "unit": "m"},
            "p_tp_pa": {"column": "p", "unit": "bar"},
        },
        "series": [
            {
                "label": "",
                "files": f"{{trial}}.{ending}",
                "cylinder": {"piston_diameter": "25 mm"},
            }
        ],
    }
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
    import_folder(tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", {}, at(0))
    campaign = load_campaign(tmp_path / "out")
    expected = {"0001": 3600.0, "0002": 0.0, "0003": 9000.0}
    assert campaign.start_times_s() == (pytest.approx(expected) if dated else {})
    if dated:
        start = datetime.fromisoformat(campaign.entries[1].origin["start"])
        assert abs(start - at(0)) < timedelta(days=1)  # local time without a zone in version 3
    else:
        assert not any("start" in entry.origin for entry in campaign.entries)

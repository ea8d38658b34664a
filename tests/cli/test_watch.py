"""``hbench watch``: what its page is told while a campaign is made and after, and to whom."""

import base64
import hashlib
import html
import http.client
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
import yaml

from hbench import workflow
from hbench.cli.watch_server import new_server
from hbench.errors import ConfigError
from hbench.store.campaign.folder import load_campaign, load_header
from hbench.store.campaign.live_file import LIVE, SCHEMA, read_live, write_live
from hbench.store.campaign.stored_acceptance import stored_checks
from hbench.workflow.watching import live, watch
from hbench.workflow.watching.charts import limits_checked, station_charts
from tests.support import ROOT
from tests.support.report.browser import Browser
from tests.support.report.spaces import ordinary_spaces
from tests.support.waiting import killed_in_the_end

SAMPLE = Path(__file__).parents[2] / "data_samples" / "bad-runs"
PATIENCE_S = 60.0


class Page:
    """A client of a watch server."""

    def __init__(self, port: int):
        self.port = port

    def ask(self, path="/", method="GET", **headers):
        """Return the response, with its body as ``text``."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)
        connection.putrequest(method, path, skip_host="Host" in headers)
        for name, value in headers.items():
            if value is not None:
                connection.putheader(name, value)
        connection.endheaders()
        response = connection.getresponse()
        response.text = response.read().decode()
        connection.close()
        return response

    def state(self):
        return json.loads(self.ask("/state.json").text)

    def runs(self):
        return json.loads(self.ask("/runs.json").text)


@contextmanager
def watched(folder, source=workflow.Watch):
    """Serve ``folder`` as the command does."""
    server = new_server(source(folder), 0)
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.05})
    thread.start()
    try:
        yield Page(server.server_port)
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


@pytest.fixture
def sample(tmp_path):
    folder = tmp_path / "bad-runs"
    shutil.copytree(SAMPLE, folder, ignore=shutil.ignore_patterns("results"))
    return folder


@pytest.fixture
def page(sample):
    with watched(sample) as client:
        yield client


def files_of(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def hbench(folder, *arguments):
    started = subprocess.Popen(
        [sys.executable, "-m", "hbench", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    return killed_in_the_end(started)


def test_a_campaign_under_way_is_told_as_the_operator_sees_it(
    on_the_rig, short_schedule, tmp_path, monkeypatch
):
    monkeypatch.setattr(live, "EVERY_S", 0.0)
    monkeypatch.setattr(watch, "_SHARE", 1e9)  # the campaign is read each time
    told, seen = [], []
    with watched(tmp_path / "campaign") as page:
        assert page.state()["state"] == "nothing"

        def report(progress):
            if told and len(told) % 8 == 0:  # what is served is what was reported before
                seen.append((told[-1], page.state(), page.runs()))
            told.append(progress)

        on_the_rig(short_schedule(), tmp_path / "campaign", report=report)
        after, runs = page.state(), page.runs()
    assert len(seen) > 3
    for before, state, made in seen:
        now = state["live"]
        assert (state["state"], now["name"], now["source"]) == ("running", "short", "simulated")
        assert (now["run"], now["runs_done"], now["runs_total"]) == (
            before.plan.run, before.runs_done, 4
        )  # fmt: skip
        assert (now["v_m_s"], now["v_ref_m_s"]) == (before.v_m_s, before.v_ref_m_s)
        assert (now["f_load_n"], now["f_load_ref_n"]) == (before.f_load_n, 2000.0)
        assert now["pressures_pa"] == before.pressures_pa
        assert {key: now[key] for key in now["trail"][-1]} == now["trail"][-1]
        assert len(now["trail"]) <= live.TRAIL
        assert len(made["runs"]) <= before.runs_done + 1  # one has ended since
    assert len(seen[-1][2]["runs"]) > 0
    assert (after["state"], after["live"]) == ("finished", None)
    assert after["said"].startswith("4 of 4 ")
    assert [run["run"] for run in runs["runs"]] == ["0001", "0002", "0003", "0004"]
    assert not (tmp_path / "campaign" / LIVE).exists()


def test_the_published_run_is_the_present_one_however_short_the_runs_are(
    on_the_rig, short_schedule, tmp_path, monkeypatch
):
    monkeypatch.setattr(live, "EVERY_S", 1e9)
    reported, published = [], []

    def report(progress):
        if reported and reported[-1] == progress.plan.run:
            published.append(read_live(tmp_path / "campaign")["run"] == progress.plan.run)
        reported.append(progress.plan.run)

    on_the_rig(short_schedule(), tmp_path / "campaign", report=report)
    assert len(set(reported)) == 4 and len(published) > 4 and all(published)


def test_a_page_that_is_opened_during_a_run_shows_the_traces_so_far(
    sample, tmp_path, monkeypatch, require_tool
):
    monkeypatch.setattr(watch, "STALE_S", PATIENCE_S)
    now = time.time()
    traced = {"v_ref_m_s": 0.05, "f_load_n": 1990.0, "f_load_ref_n": 2000.0}
    trail = [
        {"at_s": now - 20 + i, "v_m_s": 0.05 + 1e-4 * i, "pressures_pa": {"p_tp": 5e6, "p_tr": 2e6}}
        | traced
        for i in range(20)
    ]
    write_live(sample, {"trail": trail, "runs_done": 1, "runs_total": 8, **trail[-1], "at_s": now})
    with watched(sample) as page:
        dom = shown_by(require_tool("chromium"), page, tmp_path)
    lines = re.findall(r'class="trace(?: ref)?" points="([^"]*)"', dom)
    assert [len(line.split()) for line in lines] == [21] * 6


def test_a_slow_speed_keeps_its_digits_and_a_label_says_that_there_is_no_load(
    sample, tmp_path, monkeypatch, require_tool
):
    monkeypatch.setattr(watch, "STALE_S", PATIENCE_S)
    now = {"label": "no load", "kind": "steady", "direction": "extend", "f_load_ref_n": 0.0}
    now |= {"v_plan_m_s": 0.00038, "v_ref_m_s": 0.00038, "v_m_s": 0.00041, "pressures_pa": {}}
    write_live(sample, {"at_s": time.time(), "runs_done": 1, "runs_total": 8, **now})
    with watched(sample) as page:
        dom = shown_by(require_tool("chromium"), page, tmp_path)
    text = dom.replace("&nbsp;", " ")
    assert ": no load, steady, extending, 0.38 mm/s; " in text
    assert "set point 0.38 mm/s; positive: extending" in text


def test_the_verdicts_are_those_of_analyze(page, sample):
    told = page.runs()
    results = workflow.analyze(sample)
    assert told["name"] == results.provenance.name
    assert [run["reasons"] for run in told["runs"]] == [list(r.reasons) for r in results.runs]
    for run, one in zip(told["runs"], results.runs, strict=True):
        assert run["friction_n"] == (one.means.friction_n if one.means else None)


def test_a_killed_host_is_not_told_as_running(short_schedule, tmp_path, monkeypatch):
    monkeypatch.setattr(watch, "STALE_S", 1.5)
    speeds = [f"{speed} mm/s" for speed in range(50, 150, 5)]  # 400 runs: some seconds
    schedule = short_schedule(velocities=speeds, trials=20, window="5 s")
    with (
        hbench(tmp_path, "run", schedule, "-o", "out") as host,
        watched(tmp_path / "out") as page,
    ):
        deadline = time.monotonic() + PATIENCE_S
        while not page.state()["live"] or len(page.runs()["runs"]) < 2:
            assert host.poll() is None and time.monotonic() < deadline, host.communicate()
            time.sleep(0.02)
        host.kill()
        host.communicate()
        assert (tmp_path / "out" / LIVE).exists(), "it could not take its last word back"
        time.sleep(1.6)
        state = page.state()
        assert (state["state"], state["live"]) == ("silent", None)
        assert "killed" in state["said"] and "--resume" in state["said"]
        (tmp_path / "out" / LIVE).unlink()
        last = load_campaign(tmp_path / "out").entries[-1]
        in_a_run = last.stop is None  # or between two
        assert (last.plan.run if in_a_run else last.stop.at[11:19]) in page.state()["said"]


def test_an_interrupted_campaign_says_how_it_ended(on_the_rig, short_schedule, tmp_path):
    def interrupt(progress):
        if progress.runs_done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        on_the_rig(short_schedule(), tmp_path / "campaign", report=interrupt)
    assert not (tmp_path / "campaign" / LIVE).exists()
    with watched(tmp_path / "campaign") as page:
        said = page.state()["said"]
    assert said.startswith("2 of 4 ") and "--resume" in said


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[]",
        '{"schema": "another", "at_s": 1}',
        f'{{"schema": "{SCHEMA}"}}',
        f'{{"schema": "{SCHEMA}", "at_s": NaN}}',
        f'{{"schema": "{SCHEMA}", "at_s": true}}',
        f'{{"schema": "{SCHEMA}", "at_s": NOW, "x_m": 1e999}}',
        "[" * 50_000,
        "9" * 90_000,
        " " * 200_000,
    ],
    ids=lambda text: f"{text[:30]}-{len(text)}",
)
def test_a_live_file_that_no_host_wrote_is_not_believed(page, sample, text):
    (sample / LIVE).write_text(text.replace("NOW", repr(time.time())))
    assert page.state()["state"] == "finished"


def test_only_this_machine_is_served():
    server = new_server(workflow.Watch(Path("nowhere")), 0)
    try:
        assert server.server_address[0] == "127.0.0.1"
        with pytest.raises(ConnectionRefusedError):  # another address of this machine
            socket.create_connection(("127.0.0.2", server.server_port), timeout=5)
    finally:
        server.server_close()


@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        "evil.example:8350",
        "127.0.0.1.evil.example",
        "localhost.evil.example",
        "127.0.0.1:80@evil.example",
        "evil.example#localhost",
        "127.0.0.1\t",
        "0.0.0.0",
        "[::]",
        "",
        None,
    ],
)
def test_a_page_from_elsewhere_gets_nothing_even_where_its_name_points_here(page, host):
    """DNS rebinding: the browser says whose page it is in the header Host."""
    for path in ("/", "/state.json", "/runs.json"):
        answer = page.ask(path, Host=host)
        assert answer.status == 421
        assert len(answer.text) < 40 and not set("{<") & set(answer.text)


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "LOCALHOST:9", "127.0.0.1:8350"])
def test_this_machine_by_its_names_is_served(page, host):
    assert page.ask("/state.json", Host=host).status == 200


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS"])
def test_nothing_can_be_written(page, sample, method):
    before = files_of(sample)
    for path in ("/", "/state.json", "/campaign.yaml"):
        answer = page.ask(path, method)
        assert answer.status == 405 and answer.getheader("Allow") == "GET, HEAD"
    assert page.ask("/", "BREW").status == 501
    assert files_of(sample) == before


@pytest.mark.parametrize(
    "path",
    [
        "/campaign.yaml",
        "/live.json",
        "/runs/0001.dat",
        "/../campaign.yaml",
        "/%2e%2e/campaign.yaml",
        "//etc/passwd",
        "/..\\..",
        "/state.json?callback=x",
        "http://evil.example/",
        "*",
    ],
)
def test_no_file_is_served(page, path):
    assert page.ask(path, Host="127.0.0.1").status == 404


def test_reading_changes_nothing_in_the_folder(page, sample):
    before = files_of(sample)
    for path in ("/", "/state.json", "/runs.json"):
        assert page.ask(path).status == 200
        assert page.ask(path, "HEAD").text == ""
    assert files_of(sample) == before


def test_the_page_needs_nothing_else_and_may_run_nothing_but_its_own_script(page):
    answer = page.ask("/")
    text = answer.text
    assert set(re.findall(r"https?://[^\"' ]+", text)) == {"http://www.w3.org/2000/svg"}
    assert not re.search(r"innerHTML|insertAdjacentHTML|document\.write|\beval\b| on\w+=", text)
    policy = dict(
        rule.split(" ", 1) for rule in answer.getheader("Content-Security-Policy").split("; ")
    )
    assert policy["default-src"] == "'none'" and policy["frame-ancestors"] == "'none'"
    for tag in ("script", "style"):
        own = text.split(f"<{tag}>")[1].split(f"</{tag}>")[0]
        digest = base64.b64encode(hashlib.sha256(own.encode()).digest()).decode()
        assert policy[f"{tag}-src"] == f"'sha256-{digest}'"


def test_a_port_that_is_taken_is_an_error_with_a_hint():
    first = new_server(workflow.Watch(Path("nowhere")), 0)
    try:
        with pytest.raises(ConfigError, match=f"--port: .*{first.server_port}") as error:
            new_server(workflow.Watch(Path("nowhere")), first.server_port)
        assert "0" in error.value.hint
    finally:
        first.server_close()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_command_prints_its_address_and_ends_with_ctrl_c(sample, number):
    with hbench(sample.parent, "watch", sample, "--port", "0") as process:
        address = process.stdout.readline().strip()
        match = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/", address)
        assert match, address
        assert Page(int(match[1])).state()["state"] == "finished"
        process.send_signal(number)
        out, told = process.communicate(timeout=PATIENCE_S)
        assert process.returncode == 0 and not out and not told


def shown_by(chromium, page, folder):
    """Return the page's elements after its script has run for three seconds."""
    return subprocess.run(
        [chromium, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"]
        + ["--disable-background-networking", "--virtual-time-budget=3000", "--dump-dom"]
        + [f"--user-data-dir={folder / 'profile'}", f"http://127.0.0.1:{page.port}/"],
        capture_output=True,
        text=True,
        timeout=2 * PATIENCE_S,
    ).stdout


def test_a_browser_shows_the_words_of_a_hostile_campaign_as_words(sample, require_tool):
    chromium = require_tool("chromium")
    evil = "<img src=x onerror=document.title='caught'><script>document.title='caught'</script>"
    path = sample / "campaign.yaml"
    content = yaml.safe_load(path.read_text())
    content["name"] = evil
    content["runs"][0]["stop"] |= {"outcome": "failed", "why": evil}
    path.write_text(yaml.safe_dump(content, sort_keys=False))
    with watched(sample) as page:
        dom = shown_by(chromium, page, sample.parent)
    assert dom.count("&lt;img src=x") >= 3 and "<img" not in dom  # name, title, reason
    assert "<title>caught" not in dom
    assert "not running" in dom and re.search(r'id="rejected-title"[^>]*>Runs ', dom)
    assert len(load_campaign(sample).plans) > 1


def test_a_station_follows_the_campaign_that_was_changed_last(sample, tmp_path):
    folder = tmp_path / "station"
    moments = {"A": 1e9, "B": 2e9}
    for name, moment in moments.items():
        results = shutil.copytree(sample, folder / name) / "results"
        results.mkdir()
        text = json.dumps({"schema": "hbench.acceptance/1", "decision": "PASS"})
        (results / "acceptance.json").write_text(text)
        for path in (folder / name / "campaign.yaml", results / "acceptance.json"):
            os.utime(path, (moment, moment))
    before = files_of(folder)
    with watched(folder, workflow.Station) as page:
        state = page.state()
        assert [one["folder"] for one in state["cylinders"]] == ["B", "A"]
        assert {one["decision"] for one in state["cylinders"]} == {"PASS"}
        assert state["version"] == page.runs()["version"] and len(page.runs()["runs"]) > 3
        os.utime(folder / "A" / "campaign.yaml", (3e9, 3e9))
        shutil.copytree(sample, folder / "C")
        os.utime(folder / "C" / "campaign.yaml", (4e9, 4e9))
        time.sleep(1.1)  # the folder is read once a second
        state = page.state()
        assert [one["folder"] for one in state["cylinders"]] == ["C", "A", "B"]
        assert state["cylinders"][0]["decision"] == ""
    assert {path: text for path, text in files_of(folder).items() if path in before} == before


def test_a_station_lists_and_charts_cylinders_in_the_order_of_their_tests(sample, tmp_path):
    header = (sample / "campaign.yaml").read_text().partition("\nruns:")[0] + "\nruns: []\n"
    created = re.search(r"^created: '(\d{4}-\d\d-\d\d)", header, re.MULTILINE)
    folder = tmp_path / "station"
    for name, day, moment in (("A", "2026-01-05", 3e9), ("B", "2026-01-06", 1e9)):  # A changed last
        decided(folder / name, 3e5)
        path = folder / name / "campaign.yaml"
        path.write_text(header.replace(created[1], day))
        for one in (path, folder / name / "results" / "acceptance.json"):
            os.utime(one, (moment, moment))
    with watched(folder, workflow.Station) as page:
        state = page.state()
    assert [one["folder"] for one in state["cylinders"]] == ["B", "A"]
    assert state["present"] == "A" and state["charts"][0]["names"] == ["A", "B"]


def decided(folder, value, speed_m_s=None, data="good", **changes):
    """Write a decision on a breakaway pressure [Pa], as hbench accept does."""
    requirement = {"quantity": "breakaway", "unit": "bar", "low": None, "high": 4e5} | changes
    check = {
        "requirement": requirement,
        "measurement": {"value": value, "u95": 1e4, "direction": "extend", "v_m_s": speed_m_s},
        "decision": "PASS",
    }
    (folder / "results").mkdir(parents=True)
    about = {"schema": "hbench.acceptance/1", "decision": "PASS", "data": data}
    (folder / "results" / "acceptance.json").write_text(json.dumps(about | {"checks": [check]}))


def test_a_station_shows_that_a_decision_rests_on_poor_data(sample, tmp_path, require_tool):
    folder = tmp_path / "station"
    decided(folder / "A", 3e5, data="poor")
    shutil.copy(sample / "campaign.yaml", folder / "A")
    with watched(folder, workflow.Station) as page:
        dom = shown_by(require_tool("chromium"), page, tmp_path)
    assert re.search(r'class="big decision care" id="decision">PASS<span[^>]*>, data poor: ', dom)
    assert "<li>The data is poor: complete the campaign with --resume, or measure again" in dom
    assert ">PASS, data poor</td>" in dom


def test_a_station_has_control_charts_of_the_limited_quantities(sample, tmp_path, require_tool):
    folder = tmp_path / "station"
    header = (sample / "campaign.yaml").read_text().partition("\nruns:")[0] + "\nruns: []\n"
    values = [3.0e5, 3.2e5] * 6 + [4.1e5]
    for number, value in enumerate(values):
        decided(folder / f"C{number:02d}", value, speed_m_s=0.05 + 1e-5 * number)  # as measured
        path = folder / f"C{number:02d}" / "campaign.yaml"
        path.write_text(header)
        for one in (path, path.parent / "results" / "acceptance.json"):
            os.utime(one, (1e9 + number, 1e9 + number))
    with watched(folder, workflow.Station) as page:
        (chart,) = page.state()["charts"]
        assert page.state()["unusual"] == ["breakaway"] and chart["last_unusual"] is True
        dom = shown_by(require_tool("chromium"), page, tmp_path)
    assert 'aria-label="Control chart of 13 cylinders: breakaway' in dom and "+3 σ" in dom
    assert dom.count('class="value signal"') == 1 and dom.count('class="value"') == 12
    assert re.search(r'id="decision"[^>]*>PASS<span[^>]*>, unusual: check<', dom)
    assert "<li>Unusual: breakaway. The charts below show why.</li>" in dom
    assert (
        ordinary_spaces(chart["title"]) == "breakaway at 50.1 mm/s, extending"
        and chart["unit"] == "bar"
    )
    assert chart["values"] == pytest.approx([1e-5 * value for value in values])
    assert ordinary_spaces(chart["last"]).endswith("bar (95 %), limit at most 4 bar")
    assert (
        html.escape(chart["last"] + "; vertical bar: this interval").replace(
            "\N{NO-BREAK SPACE}", "&nbsp;"
        )
        in dom
    )
    assert chart["u95"] == pytest.approx([0.1] * 13) and dom.count('class="uncertainty"') == 1
    assert (chart["low"], chart["high"]) == (None, pytest.approx(4.0))
    mean, moving = np.mean(values), np.abs(np.diff(values)).mean() / 1.128
    assert chart["control"] == pytest.approx([1e-5 * (mean + step * moving) for step in (-3, 0, 3)])
    assert "beyond 3 σ" in chart["signals"][-1] and not any(chart["signals"][:-1])
    assert "Last mark: C12, beyond 3 σ.<" in dom
    assert 'id="rejections" hidden=""' in dom and 'id="rings">Dashed lines: usual range' in dom
    assert "a value outside this range; it can still meet its limit." in dom
    decided(tmp_path / "few" / "C", 3e5)
    (tmp_path / "few" / "C" / "campaign.yaml").write_text(header)
    failed = tmp_path / "few" / "C" / "results" / "acceptance.json"
    failed.write_text(failed.read_text().replace("PASS", "FAIL"))
    with watched(tmp_path / "few", workflow.Station) as page:
        (chart,) = page.state()["charts"]
        (cylinder,) = page.state()["cylinders"]
        assert page.state()["unusual"] == []
    assert cylinder["decision"] == "FAIL" and "do not deliver" in cylinder["next"][0]
    assert chart["control"] is None and chart["values"] == pytest.approx([3.0])


def test_a_station_states_what_did_not_pass_and_charts_it_first(tmp_path):
    decided(tmp_path, 3e5)
    path = tmp_path / "results" / "acceptance.json"
    content = json.loads(path.read_text())
    (check,) = content["checks"]
    marginal, failed = check | {"decision": "MARGINAL"}, check | {"decision": "FAIL"}
    failed |= {"requirement": check["requirement"] | {"name": "5.3", "high": 2e5}}
    untested = check | {"decision": "NOT TESTED", "measurement": None, "reason": "no runs"}
    path.write_text(json.dumps(content | {"checks": [check, marginal, untested, failed]}))
    checks = stored_checks(tmp_path)
    kept, first, second, third = map(ordinary_spaces, limits_checked(checks))
    assert kept == "Limits met: 1 of 4."
    assert first == ("FAIL: 5.3: breakaway, extending: 3.00 ± 0.10 bar (95 %), limit at most 2 bar")
    assert second.startswith("MARGINAL: breakaway, extending: ")
    assert third == ("NOT TESTED: breakaway: no runs; limit at most 4 bar")
    titles = [chart["title"] for chart in station_charts(["C"], [checks])]
    breakaway = "breakaway, extending"
    assert titles == [f"5.3: {breakaway}", breakaway, breakaway]
    passed, nearest = map(ordinary_spaces, limits_checked(checks[:1]))
    assert passed == "Limits met: 1 of 1."
    assert "3.00 ± 0.10 bar, limit at most 4 bar, margin 1.0 bar." in nearest
    several = limits_checked(checks * 5)
    assert len(several) == 6 and several[-1].startswith("11 more") and limits_checked([]) == []


def test_a_run_that_was_stopped_has_one_reason_and_is_not_counted_as_rejected(
    sample, tmp_path, require_tool
):
    path = tmp_path / "station" / "C" / "campaign.yaml"
    shutil.copytree(sample, path.parent)
    content = yaml.safe_load(path.read_text())
    content["runs"] = content["runs"][:3]
    content["runs"][2]["stop"] |= {"outcome": "aborted", "why": "interrupted by the operator"}
    path.write_text(yaml.safe_dump(content, sort_keys=False))
    with watched(tmp_path / "station", workflow.Station) as page:
        last = page.runs()["runs"][-1]
        dom = shown_by(require_tool("chromium"), page, tmp_path)
    assert last["reasons"][0] == "aborted: interrupted by the operator"
    assert "run 0003 aborted: interrupted by the operator." in dom
    assert re.findall(r"<td>0003</td><td>(.*?)</td>", dom) == [last["reasons"][0]]
    poor, title = (
        re.search(rf'id="{name}"[^>]*>(.*?)<', dom)[1] for name in ("shares", "rejected-title")
    )
    assert " of 2 completed runs" in poor and "stopped: 1" in title


def test_runs_without_a_constant_speed_are_counted_where_the_friction_would_be(
    tmp_path, require_tool
):
    """An acceptance test begins with them, and a leakage test has no others."""
    folder = tmp_path / "campaign"
    shutil.copytree(ROOT / "data_samples" / "blind" / "none-5", folder)
    path = folder / "campaign.yaml"
    content = yaml.safe_load(path.read_text())
    content["runs"] = [run for run in content["runs"] if run["plan"]["kind"] != "steady"]
    path.write_text(yaml.safe_dump(content, sort_keys=False))
    with watched(folder) as page:
        dom = shown_by(require_tool("chromium"), page, tmp_path)
    assert 'id="made-title">Accepted runs<' in dom
    assert re.search(r'id="plot">4 triangles and 2 holds\. No steady run is accepted', dom)


def test_a_station_shows_an_interrupted_campaign_and_its_rejected_runs(
    sample, tmp_path, require_tool
):
    path = tmp_path / "station" / "C" / "campaign.yaml"
    shutil.copytree(sample, path.parent)
    path.write_text(path.read_text().partition("- run: '0008'")[0])
    with watched(tmp_path / "station", workflow.Station) as page:
        dom = shown_by(require_tool("chromium"), page, tmp_path)
    assert re.search(r'class="big decision bad" id="decision">interrupted<', dom)
    assert "6 of 7 completed runs were rejected" in dom
    checked = re.search(r'<ul id="checked">(.*?)</ul>', dom)
    assert "No decision: the test is not complete." in checked[1]
    assert "Continue with hbench run --resume" in dom


@pytest.mark.parametrize(
    "changes",
    [
        {"quantity": "leakage", "unit": "ml/min", "leak": "across_piston"},
        {"quantity": "leakage", "unit": "cm^3/h", "leak": "rod_side_out"},
        {"quantity": "efficiency", "unit": "%"},
    ],
)
def test_a_decision_in_any_unit_of_limits_is_read_back(tmp_path, changes):
    decided(tmp_path, 1e-9, **changes)
    (check,) = stored_checks(tmp_path)
    assert (check.requirement.unit, check.measurement.value) == (changes["unit"], 1e-9)


def test_why_a_measured_value_was_not_decided_is_read_back(tmp_path):
    decided(tmp_path, 1.0)
    path = tmp_path / "results" / "acceptance.json"
    content = json.loads(path.read_text())
    (check,) = content["checks"]
    reason = "the uncertainty is not known"
    content["checks"] = [check | {"decision": "NOT TESTED", "reason": reason}]
    path.write_text(json.dumps(content))
    (check,) = stored_checks(tmp_path)
    assert (check.measurement.value, check.reason) == (1.0, reason)


@pytest.mark.parametrize(
    ("changes", "measured"),
    [
        ({"quantity": "__class__"}, 1.0),
        ({"unit": "parsec"}, 1.0),
        ({"high": "1e999"}, 1.0),
        ({"direction": ["extend"]}, 1.0),
        ({}, True),
        ({}, None),
        ({}, float("inf")),
    ],
)
def test_a_decision_that_hbench_did_not_write_is_not_charted(tmp_path, changes, measured):
    decided(tmp_path, measured, **changes)
    assert stored_checks(tmp_path) == ()


def test_a_header_is_read_without_the_runs(sample):
    path = sample / "campaign.yaml"
    whole = load_campaign(sample)
    path.write_text(path.read_text() + "- not: [a run\n" * 1000)
    header = load_header(sample)
    assert header.header == whole.header and header.entries == ()


def test_a_station_without_a_campaign_waits(tmp_path):
    with watched(tmp_path / "nothing", workflow.Station) as page:
        assert page.state()["state"] == "nothing" and page.state()["cylinders"] == []


def test_a_station_is_printed_with_all_its_cylinders(sample, tmp_path, require_tool):
    """On the screen the list of 14 cylinders scrolls, and its title says so."""
    folder = tmp_path / "station"
    for number in range(14):
        shutil.copytree(sample, folder / f"HC-{number:02d}")
    browser = Browser(require_tool("chromium"), tmp_path / "profile")
    try:
        with watched(folder, workflow.Station) as page:
            browser.ask("Page.navigate", url=f"http://127.0.0.1:{page.port}/")
            deadline = time.monotonic() + PATIENCE_S
            rows = "document.querySelectorAll('#cylinders tr, #plot svg').length"
            while browser.run(rows) < 15 and time.monotonic() < deadline:
                time.sleep(0.2)
            hidden = (
                "(l => l.scrollHeight - l.clientHeight)"
                "(document.querySelector('#cylinders').closest('.list'))"
            )
            hint = "getComputedStyle(document.querySelector('#history-title'), '::after').content"
            assert browser.run(hidden) > 0
            said = browser.run(hint).strip('"')
            shown, more = map(
                int, re.fullmatch(r"; (\d+) shown, scroll for (\d+) more", said).groups()
            )
            in_view = (
                "(l => [...document.querySelectorAll('#cylinders tr')].filter(r => "
                "r.getBoundingClientRect().bottom <= l.getBoundingClientRect().bottom + 1).length)"
                "(document.querySelector('#cylinders').closest('.list'))"
            )
            assert shown == browser.run(in_view) and shown + more == 14
            # A row is shown whole or not at all, also after the page has become narrow.
            browser.ask(
                "Emulation.setDeviceMetricsOverride", width=400, height=800,
                deviceScaleFactor=1, mobile=False,
            )  # fmt: skip
            cut = (
                "(l => [...document.querySelectorAll('#cylinders tr')].filter(r => "
                "r.getBoundingClientRect().top < l.getBoundingClientRect().bottom - 1 && "
                "r.getBoundingClientRect().bottom > l.getBoundingClientRect().bottom + 1).length)"
                "(document.querySelector('#cylinders').closest('.list'))"
            )
            deadline = time.monotonic() + PATIENCE_S
            while browser.run(cut) and time.monotonic() < deadline:
                time.sleep(0.05)
            assert browser.run(cut) == 0
            name = "(n => n.scrollWidth - n.clientWidth)(document.querySelector('#station'))"
            assert browser.run(name) == 0
            # Letters of a figure keep their size: it is drawn again at the new width.
            drawn = "(p => p.getBoundingClientRect().width / p.viewBox.baseVal.width)"
            assert abs(browser.run(f"{drawn}(document.querySelector('#plot svg'))") - 1) < 0.02
            # On paper a figure is drawn at the width of the sheet, however wide the window is.
            browser.width(1440)
            browser.run("dispatchEvent(new Event('beforeprint'))")
            width = "document.querySelector('#plot svg').viewBox.baseVal.width"
            assert 500 < browser.run(width) < 680
            browser.run("dispatchEvent(new Event('afterprint'))")
            assert browser.run(width) > 700
            # A list does not scroll for one row more.
            one_more = (
                "(() => { for (const list = document.querySelector('#cylinders'); "
                f"list.rows.length > {shown + 1};) list.rows[0].remove(); "
                "wholeRows($('cylinders'), $('history-title')); "
                f"return {hidden}; }})()"
            )
            assert browser.run(one_more) == 0
            # A remark is not repeated when the page is drawn again.
            twice = (
                "(() => { const now = structuredClone(shownNow), [latest] = now.cylinders; "
                "Object.assign(now, {state: 'finished', unusual: ['friction'], "
                "present: latest.folder}); "
                "Object.assign(latest, {decision: 'PASS', next: ['next'], checked: []}); "
                "showStation(now); showStation(now); "
                "return [...document.querySelectorAll('#checked li')].map(row => row.innerText); "
                "})()"
            )
            assert [each.split()[0] for each in browser.run(twice)] == ["Unusual:", "next"]
            browser.ask("Emulation.setEmulatedMedia", media="print")
            assert browser.run(hidden) == 0 and browser.run(hint) == "none"
            colour = "getComputedStyle(document.querySelector('.travel i')).printColorAdjust"
            assert browser.run(colour) == "exact"  # else the piston is not on the sheet
    finally:
        browser.close()


@pytest.mark.parametrize("option", [(), ("--station",)])
def test_a_file_is_refused_before_a_page_is_served(tmp_path, option):
    file = tmp_path / "run.csv"
    file.write_text("t_s\n")
    with hbench(tmp_path, "watch", file, *option) as process:
        out, told = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 2 and not out
    assert f"{file}: is a file" in told and "Give the campaign's folder." in told


@pytest.mark.parametrize(
    ("option", "words"),
    [((), "is a folder of campaigns"), (("--station",), "is a campaign")],
)
def test_a_folder_that_the_other_page_is_for_is_refused(tmp_path, option, words):
    (tmp_path / "line" / "one").mkdir(parents=True)
    (tmp_path / "line" / "one" / "campaign.yaml").touch()
    folder = tmp_path / "line" / "one" if option else tmp_path / "line"
    with hbench(tmp_path, "watch", folder, *option) as process:
        out, told = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 2 and not out
    assert f"{folder}: {words}" in told and "--station" in told

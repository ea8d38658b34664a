"""Two processes make what one would."""

import os
import signal
import subprocess
import sys
import threading

import pytest

from hbench.parallel.forked import map_forked
from hbench.report.campaign.results_document import results_json
from hbench.store.campaign.folder import load_campaign
from hbench.workflow.results import derive, screened_runs
from tests.support import ROOT

IN_A_PROCESS_OF_ITS_OWN = """
import os
from hbench.parallel.forked import map_forked

def work(thing):
    return thing(), os.getpid()

made = map_forked(work, [lambda n=n: n * n for n in range(20)])  # no lambda can be pickled
assert [square for square, _ in made] == [n * n for n in range(20)]
assert os.getpid() not in {pid for _, pid in made}
try:
    map_forked(lambda thing: 1 / thing, [1, 0])
except ZeroDivisionError:
    print("told")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="forks on Linux alone")
def test_other_processes_make_all_in_order_and_their_errors_are_raised():
    done = subprocess.run(
        [sys.executable, "-c", IN_A_PROCESS_OF_ITS_OWN], capture_output=True, text=True
    )
    assert (done.returncode, done.stdout) == (0, "told\n"), done.stderr


KILLED = """
import os, signal, time
from hbench.parallel.forked import map_forked

def work(number):
    if number:
        os.kill(parent, signal.SIGKILL)
    time.sleep(60)

parent = os.getpid()
map_forked(work, [0, 1])
"""


@pytest.mark.skipif(sys.platform != "linux", reason="forks on Linux alone")
def test_they_end_soon_after_a_parent_that_is_killed():
    """The pipe of their output ends with the last of them."""
    done = subprocess.run([sys.executable, "-c", KILLED], stdout=subprocess.PIPE, timeout=30)
    assert done.returncode == -signal.SIGKILL


SCHEDULE = """
name: steady runs between two zero checks
bench: {bench}
experiments:
  - kind: check
  - kind: steady
    direction: extend
    p_lr: 15 bar
    loads: [500 N, 2000 N]
    velocities: {{first: 20 mm/s, last: 200 mm/s, count: 8}}
    trials: 7
    travel: {{start: 40 mm, end: 340 mm}}
    acceleration: 1 m/s^2
    hold: 0.1 s
    window: 0.5 s
  - kind: check
"""


def test_a_campaign_is_analyzed_as_by_one_process(tmp_path):
    """Each process screens a part of the runs; their zeros follow the times of the whole."""
    folder, schedule = tmp_path / "demo", tmp_path / "schedule.yaml"
    schedule.write_text(SCHEDULE.format(bench=ROOT / "configs" / "bench-aau.yaml"))
    for arguments in ("run", schedule, "-o", folder), ("analyze", folder):
        command = [sys.executable, "-P", "-m", "hbench", *map(str, arguments)]
        subprocess.run(command, check=True, capture_output=True)
    campaign = load_campaign(folder)
    assert len(campaign.latest) == 114
    results = derive(campaign)
    assert (folder / "results" / "results.json").read_text() == results_json(results)
    one_by_one = [screened.means for screened in screened_runs(campaign)]
    assert [screened.means for screened in results.runs] == one_by_one


def test_where_there_is_a_thread_nothing_is_forked():
    stop = threading.Event()
    thread = threading.Thread(target=stop.wait)
    thread.start()
    try:
        assert map_forked(lambda _: os.getpid(), [1, 2, 3]) == [os.getpid()] * 3
    finally:
        stop.set()
        thread.join()

"""The source's whole experiment is analysed in well under a second."""

import time
from dataclasses import replace

import numpy as np

from hbench.analysis.average import curves
from hbench.analysis.calibrate import calibrate
from hbench.analysis.efficiency import efficiency
from hbench.analysis.fit import fits
from hbench.analysis.screen import screen
from hbench.model.sensors import sensor_gains
from hbench.records import LogChannel, RawRun

SENSORS = ("x", "p_tp", "p_tr", "f_applied")


def as_log(run, bench):
    """Turn a run back into the words that a board would have logged."""
    gains = sensor_gains(bench.sensors)
    fields = (run.x_m, run.p_tp_pa, run.p_tr_pa, run.f_applied_n)
    counts = [
        16 * (values - gains[name][1]) / gains[name][0]
        for name, values in zip(SENSORS, fields, strict=True)
    ]
    n = len(run.t_s)
    flags = run.at_reference + 8 * (np.arange(n) == n - 1)
    words = np.column_stack([np.ones(n), np.arange(n), flags, *counts])
    names = ("run", "index", "flags", *SENSORS)
    channels = tuple(
        LogChannel(name, False, 1 / 16 if name in SENSORS else 1, "count") for name in names
    )
    bits = ("at_reference", "sensor_saturated", "valve_saturated", "last")
    return RawRun(run.plan, np.round(words).astype(np.uint16), channels, bits, 100.0, "done")


def test_360_runs_of_400_records_take_well_under_a_second(make_run, bench, rules):
    speeds = np.linspace(0.01, 0.08, 15)
    logs = []
    for direction in (1, -1):
        for load in (500.0, 1000.0, 2000.0, 5000.0):
            for v in speeds:
                friction = 300 + 200 * np.exp(-v / 0.06) + 1500 * v
                run = make_run(
                    v_m_s=direction * v,
                    f_applied_n=load,
                    friction_n=friction,
                    duration_s=4.0,
                    noise=1.0,
                )
                log = as_log(run, bench)
                logs += [replace(log, plan=replace(log.plan, trial=i)) for i in (1, 2, 3)]
    assert len(logs) == 360 and len(logs[0].words) == 400

    start = time.perf_counter()
    screened = [screen(calibrate(log, bench), rules) for log in logs]
    found = curves(screened)
    fitted = [fits(curve) for curve in found]
    etas = [efficiency(curve, bench.instruments) for curve in found]
    took = time.perf_counter() - start

    assert all(one.accepted for one in screened)
    assert len(found) == len(etas) == 8 and all(fit.converged for one in fitted for fit in one)
    assert took < 1.0
    print(f"{1e3 * took:.0f} ms")

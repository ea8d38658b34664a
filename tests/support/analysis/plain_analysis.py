"""A campaign analyzed as a script of a page would do it, with pandas and lmfit alone.

``python plain_analysis.py CAMPAIGN``.
"""

import sys
from pathlib import Path

import lmfit
import numpy as np
import pandas as pd
import yaml

from hbench.config.bench import parse_bench
from hbench.config.fitting import TABLE_6_1
from hbench.model.sensors import sensor_gains


def plain_pipeline(folder):
    """Read, scale, average the window, group, fit, write; return the points of the curves."""
    header, runs = load_yaml(folder / "campaign.yaml")
    bench = parse_bench(header["bench"]["content"], "bench")
    gains = sensor_gains(bench.sensors)
    channels = header["log"]["channels"]
    names = [channel["name"] for channel in channels]
    rows = []
    for plan in runs:
        cells = pd.read_csv(folder / "runs" / f"{plan['run']}.dat", skiprows=1, header=None)[0]
        words = cells.map(lambda word: int(str(word), 16)).to_numpy().reshape(-1, len(names))
        log = pd.DataFrame(words, columns=names)
        for name in ("x", "p_tp", "p_tr", "f_applied"):
            gain, offset = gains[name]
            log[name] = gain * log[name] / 16 + offset
        t = (log["index"] + 0.5) / 100
        reached = (log["flags"] & 1 == 1).idxmax()
        travelled = (log.x - log.x[reached]).abs() >= 0.02
        window = log[(t >= t[reached] + 0.3) & travelled & (log.index >= reached)]
        specimen = plan["specimen"]
        f_test = window.p_tp * specimen["area_piston_m2"] - window.p_tr * specimen["area_rod_m2"]
        slope = np.polyfit(t[window.index], window.x, 1)[0]
        mean = {"v": slope, "friction": (f_test - window.f_applied).mean(), "f_test": f_test.mean()}
        rows.append({**plan, **mean, "f_applied": window.f_applied.mean()})
    table = pd.DataFrame(rows)
    table["direction"] = np.sign(table.v_ref_m_s)
    points = table.groupby(["direction", "f_load_n", "v_ref_m_s"], as_index=False).agg(
        v=("v", "mean"), friction=("friction", "mean"), s=("friction", "std"), n=("v", "size"),
        f_test=("f_test", "mean"), f_applied=("f_applied", "mean"),
    )  # fmt: skip
    points["ci95"] = 4.303 * points.s / np.sqrt(points.n)
    points["efficiency"] = points.f_applied / points.f_test

    fits = []
    for key, curve in points.groupby(["direction", "f_load_n"]):
        model, parameters = tustin_model()
        friction = curve.friction.abs().to_numpy()
        fit = model.fit(friction, parameters, v=curve.v.abs().to_numpy())
        fits.append({"curve": key, **fit.best_values})
    out = folder / "plain"
    out.mkdir(exist_ok=True)
    table.drop(columns="specimen").to_csv(out / "runs.csv")
    points.to_csv(out / "curves.csv")
    pd.DataFrame(fits).to_csv(out / "fits.csv")
    return points


def tustin(v, f_coulomb_n, f_stiction_n, v_stribeck_m_s, b_viscous_n_s_m):
    e = np.exp(-v / v_stribeck_m_s)
    return f_coulomb_n + (f_stiction_n - f_coulomb_n) * e + b_viscous_n_s_m * v


def two_lines(v, intercept_n, low_n_s_m, high_n_s_m, v_switch_m_s):
    low = np.minimum(v, v_switch_m_s)
    return intercept_n + low_n_s_m * low + high_n_s_m * (v - low)


def tustin_model():
    model = lmfit.Model(tustin)
    parameters = model.make_params(
        f_coulomb_n=200, f_stiction_n=500, v_stribeck_m_s=0.07, b_viscous_n_s_m=2000
    )
    for name in parameters:
        low, high = getattr(TABLE_6_1, name)
        parameters[name].set(min=low, max=high)
    return model, parameters


def two_lines_model(speeds):
    model = lmfit.Model(two_lines)
    parameters = model.make_params(
        intercept_n=500, low_n_s_m=-2000, high_n_s_m=2000, v_switch_m_s=0.07
    )
    parameters["v_switch_m_s"].set(min=speeds[1], max=speeds[-2])
    return model, parameters


def intervals_and_held_out_errors(points):
    """The profile intervals of two laws of each curve, and their errors at held-out speeds."""
    found = []
    for key, curve in points.groupby(["direction", "f_load_n"]):
        curve = curve.assign(v=curve.v.abs(), friction=curve.friction.abs()).sort_values("v")
        v, friction = curve.v.to_numpy(), curve.friction.to_numpy()
        for model, parameters in (tustin_model(), two_lines_model(v)):
            fit = model.fit(friction, parameters, v=v)
            intervals, errors = fit.conf_interval(sigmas=[0.95]), []
            for out in range(1, len(v) - 1):
                others = np.arange(len(v)) != out
                refit = model.fit(friction[others], fit.params, v=v[others])
                errors.append(refit.eval(v=v[out]) - friction[out])
            found.append((key, intervals, errors))
    return found


def load_yaml(path):
    """The campaign's header and the plans of its steady runs."""
    content = yaml.load(path.read_text(), Loader=yaml.CSafeLoader)
    starts = [item for item in content["runs"] if item["plan"]["kind"] == "steady"]
    return content, [{"run": item["run"], **item["plan"]} for item in starts]


if __name__ == "__main__":
    plain_pipeline(Path(sys.argv[1]))

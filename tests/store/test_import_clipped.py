"""A foreign channel at its converter's end is noticed; quiet and coarse ones are not accused."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from hbench import workflow
from hbench.store.importing.clipping import clipped_samples, frozen_samples, suspected_samples

CONFIGS = Path(__file__).parents[2] / "configs"
N = 3000


def channels(p, **others):
    t = 0.01 * np.arange(len(p))
    return {"t_s": t, "x_m": 0.05 * t + 1e-9 * np.arange(len(p)) ** 2, "p_tp_pa": p, **others}


def pressure(noise=2e4, seed=1, counts=None):
    """60 to 100 bar with noise; ``counts`` is a converter's step."""
    p = 80e5 + 20e5 * np.sin(np.arange(N) / 200)
    p = p + noise * np.random.default_rng(seed).standard_normal(N)
    return p if counts is None else counts * np.rint(p / counts)


@pytest.mark.parametrize("counts", [None, 250e5 / 4096])
@pytest.mark.parametrize(("low", "high"), [(-np.inf, 95e5), (62e5, np.inf), (62e5, 95e5)])
def test_a_cut_channel_is_found_with_each_of_its_samples(low, high, counts):
    p = pressure(counts=counts)
    if counts:
        low, high = counts * np.rint(low / counts), counts * np.rint(high / counts)
    cut = np.clip(p, low, high)
    found = clipped_samples(channels(cut))
    np.testing.assert_array_equal(found["p_tp_pa"], (p <= low) | (p >= high))


@pytest.mark.parametrize(
    "p",
    [
        pressure(),
        pressure(counts=250e5 / 4096),
        pressure(noise=0.0, counts=1e5),  # stays at the top of each wave
        100e5 * (1 - np.exp(-np.arange(N) / 300)) // 1e4 * 1e4,  # settles
        np.full(N, 80e5),
        np.where(np.arange(N) % 2, 80e5, 80.1e5),
        pressure(counts=4e4),
    ],
    ids="lively fine quiet settled constant two-valued coarse".split(),
)
def test_a_whole_channel_is_not_accused(p):
    assert clipped_samples(channels(p)) == {}


def test_a_hundred_lively_channels_are_not_accused():
    accused = [clipped_samples(channels(pressure(seed=s, counts=250e5 / 4096))) for s in range(100)]
    assert not any(accused)


def test_a_channel_that_oscillates_first_and_settles_at_its_maximum_is_not_accused():
    counts, held_at_maximum, accused = 250e5 / 4096, 0, []
    for seed in range(1000):
        rng = np.random.default_rng(seed)
        start = 70e5 + 4 * counts * rng.standard_normal(300)  # lively
        settled = 80e5 + counts * (np.arange(90) / 10 + 0.9 * rng.standard_normal(90))
        p = counts * np.rint(np.concatenate([start, settled]) / counts)
        at_maximum = "".join("x" if at else "." for at in p == p.max())
        held_at_maximum += "xxx" in at_maximum
        accused.append(clipped_samples(channels(p)))
    assert held_at_maximum >= 5  # as in a clipped channel
    assert not any(accused)


def test_a_log_that_has_stopped_is_no_clipped_channel():
    p, t = pressure(), 0.01 * np.arange(N)
    top = int(np.argmax(p))
    x = 0.05 * t
    p[top : top + 50], x[top : top + 50] = p[top], x[top]
    assert clipped_samples({"t_s": t, "x_m": x, "p_tp_pa": p}) == {}


def test_a_clipped_stroke_is_rejected_with_channel_and_value(tmp_path, clock):
    (tmp_path / "logs").mkdir()
    rng = np.random.default_rng(8)
    t = 0.004 * np.arange(800)
    x = 10 + 50 * np.maximum(0, t - 1)
    force = np.where(t > 1, 2.0, 0.0) + 0.01 * rng.standard_normal(len(t))
    for trial, level in ((1, 27.0), (2, 31.0)):
        p = np.where(t > 1, level, 0.0) + 0.05 * rng.standard_normal(len(t))
        rows = zip(1e3 * t, x, np.clip(p, None, 31.02), 0 * t, force, strict=True)
        text = "#\nZeit;Weg;p_A;p_B;Kraft\nms;mm;bar;bar;kN\n"
        text += "".join(";".join(f"{v:.4f}".replace(".", ",") for v in row) + "\n" for row in rows)
        (tmp_path / "logs" / f"NBR_50mm_s_2000N_{trial}.csv").write_text(text)
    folder = tmp_path / "campaign"
    workflow.import_runs(tmp_path / "logs", folder, CONFIGS / "import-csv.yaml", clock)
    results = workflow.analyze(folder)
    whole, cut = results.runs
    assert whole.accepted
    (reason,) = cut.reasons
    assert reason.startswith("sensor_saturated: P_Tp is at its maximum, 31.0 bar, in ")
    assert reason.endswith("records of the window (none allowed)")
    assert any("2.csv: p_tp_pa: clipped at 31.02 bar" in note for note in results.notes)
    assert results.curves[0].points[0].trials == (1,)


def test_a_saturated_amplifier_with_noise_of_one_count_is_suspected():
    """The converter does not clip: the limit is that of an amplifier, a count up and down."""
    counts = 250e5 / 4096
    whole, found = 0, []
    for seed in range(50):
        p = pressure(seed=seed, counts=counts)
        top = counts * np.rint(95e5 / counts)
        noise = counts * np.random.default_rng(seed).integers(-1, 2, N)
        cut = np.where(p >= top, top + noise, p)
        assert clipped_samples(channels(cut)) == {}
        found.append(suspected_samples(channels(cut), {})["p_tp_pa"].sum() / (p >= top).sum())
        whole += suspected_samples(channels(p), {}) != {}
    assert whole == 0 and np.mean(found) > 0.5


def test_a_channel_that_settles_at_its_maximum_is_not_suspected():
    counts = 250e5 / 4096
    for seed in range(300):
        rng = np.random.default_rng(seed)
        start = 70e5 + 4 * counts * rng.standard_normal(300)
        settled = 80e5 + counts * (np.arange(90) / 10 + 0.9 * rng.standard_normal(90))
        p = counts * np.rint(np.concatenate([start, settled]) / counts)
        assert suspected_samples(channels(p), {}) == {}


def of_a_stroke(rate_hz=500, seed=5):
    """A pressure that pulses, with pump ripple and the noise of a sensor; counts of 0.01 bar."""
    t = np.arange(6 * rate_hz) / rate_hz
    p = 40e5 + 3e5 * np.sign(np.sin(2 * t)) + 4e4 * np.sin(2 * np.pi * 31 * t)
    p += 8e3 * np.random.default_rng(seed).standard_t(6, len(t))
    return 1e3 * np.rint(p / 1e3)


@pytest.mark.parametrize("of", [(900, 1500), (1700, 3000), (0, 400)])
def test_a_channel_that_repeats_its_value_amid_noise_is_frozen(of):
    p = of_a_stroke()
    p[slice(*of)] = p[of[0]]
    expected = np.zeros(len(p), dtype=bool)
    expected[slice(*of)] = True
    found = frozen_samples(channels(p), {})
    np.testing.assert_array_equal(found["p_tp_pa"], expected)


@pytest.mark.parametrize(
    "p",
    [
        of_a_stroke(),
        np.repeat(of_a_stroke()[::40], 40),  # a slow bus repeats each value
        np.where(np.arange(N) < 900, of_a_stroke(), 4e4 * np.rint(of_a_stroke() / 4e4)),  # settles
        np.where(np.arange(N) < 900, 30e5 + 500.0 * np.arange(N), 34.8e5),  # a ramp without noise
        np.where(np.arange(N) % 700 < 350, of_a_stroke(), 0.0),  # a valve vents the chamber
        np.full(N, 80e5),
    ],
    ids="lively repeated coarse ideal vented constant".split(),
)
def test_a_channel_that_is_quiet_for_another_reason_is_not_frozen(p):
    clipped = clipped_samples(channels(p))
    assert frozen_samples(channels(p), clipped) == {}


def test_a_log_that_stops_has_no_frozen_channel():
    p = of_a_stroke()
    p[2000:] = p[2000]
    stopped = channels(p, f_applied_n=np.concatenate([of_a_stroke(seed=6)[:2000], np.ones(1000)]))
    stopped["x_m"] = np.minimum(stopped["x_m"], stopped["x_m"][2000])
    assert "p_tp_pa" not in frozen_samples(stopped, {})


def test_a_frozen_pressure_rejects_its_stroke_by_name_and_not_the_weight_of_the_map(
    tmp_path, clock
):
    (tmp_path / "logs").mkdir()
    rng = np.random.default_rng(11)
    t = np.arange(900) / 200
    x = 20 + 60 * np.clip(t - 1, 0, 3)
    for trial in (1, 2):
        p = np.round(31 + 2 * np.sin(9 * t) + 0.08 * rng.standard_normal(len(t)), 2)
        if trial == 2:
            p[520:640] = p[520]
        rows = np.column_stack([t, x, p])
        np.savetxt(tmp_path / f"logs/{trial}.csv", rows, "%.4f", ",", header="t,x,p", comments="")
    columns = {"t_s": ("t", "s"), "x_m": ("x", "mm"), "p_tp_pa": ("p", "bar")}
    rules = {
        "name": "weight",
        "columns": {key: {"column": c, "unit": unit} for key, (c, unit) in columns.items()},
        "constants": {"p_tr_pa": "0 bar", "f_applied_n": "785 N"},
        "screening": {"friction_drift": "5 kN"},
        "series": [
            {"label": "A", "files": "{trial}.csv", "cylinder": {"piston_diameter": "50 mm"}}
        ],
    }
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
    workflow.import_runs(tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", clock)
    whole, frozen = workflow.analyze(tmp_path / "out").runs
    assert whole.accepted
    (reason,) = frozen.reasons
    assert reason.startswith("sensor_saturated: P_Tp is frozen at ")
    assert "F_applied" not in reason and " in 120 of the " in reason

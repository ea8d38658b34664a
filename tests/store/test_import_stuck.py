"""A sensor that is stuck in one file is noticed by the other files; quiet channels are not."""

import numpy as np
import pytest
import yaml

from hbench import workflow

AREA = np.pi / 4 * 0.04**2


def log(seed, *, stuck=False, regulated=False, load=500.0, full_scale=np.inf):
    """Return a stroke out and back at 20 mm/s with 100 N of friction."""
    rng = np.random.default_rng(seed)
    t = 0.01 * np.arange(1200)
    x = np.interp(t, [1, 6, 6.5, 11.5], [0.01, 0.11, 0.11, 0.01])
    p_r = np.full(len(t), 20e5) if regulated else 20e5 + 2e5 * rng.standard_normal(len(t))
    p_p = (20e5 * AREA + load + 100 * np.sign(np.gradient(x))) / AREA
    p_p = p_p + 1e3 * rng.standard_normal(len(t))
    f = load + 0.1 * rng.standard_normal(len(t)) if load else np.zeros(len(t))
    if stuck:
        p_p[:] = p_p[0]
    f = np.minimum(f, full_scale)
    rows = np.column_stack([t, 1e3 * x, p_p / 1e5, p_r / 1e5, f])
    return "t,x,a,b,f\n" + "".join(",".join(f"{v:.6f}" for v in row) + "\n" for row in rows)


@pytest.fixture
def bring_in(tmp_path, clock):
    def bring_in(**files):
        logs = tmp_path / "logs"
        logs.mkdir()
        for number, text in enumerate(files.values(), start=1):
            (logs / f"{number}.csv").write_text(text)
        units = {"t_s": "s", "x_m": "mm", "p_tp_pa": "bar", "p_tr_pa": "bar", "f_applied_n": "N"}
        columns = {
            name: {"column": column, "unit": unit}
            for (name, unit), column in zip(units.items(), "txabf", strict=True)
        }
        cylinder = {"piston_area": f"{1e6 * AREA} mm^2", "rod_area": f"{1e6 * AREA} mm^2"}
        rules = {
            "name": "stuck",
            "columns": columns,
            "series": [{"label": "", "files": "{trial}.csv", "cylinder": cylinder}],
            "cut": "reversals",
        }
        map_file = tmp_path / "map.yaml"
        map_file.write_text(yaml.safe_dump(rules))
        summary = workflow.import_runs(logs, tmp_path / "out", map_file, clock)
        screened = workflow.analyze(tmp_path / "out").runs
        previewed = [run.screened for run in workflow.preview_import(logs, map_file).runs]
        assert [run.reasons for run in previewed] == [run.reasons for run in screened]
        return summary.notes, [run.reasons for run in screened]

    return bring_in


def test_runs_of_a_stuck_sensor_are_rejected_and_the_file_is_named(bring_in):
    notes, reasons = bring_in(a=log(1), b=log(2, stuck=True), c=log(3))
    assert [bool(each) for each in reasons] == [False, False, True, True, False, False]
    assert all(each[0].startswith("sensor_saturated: ") for each in reasons[2:4])
    assert all("P_Tp is constant at 24" in each[0] for each in reasons[2:4])
    assert [note for note in notes if "stuck" in note][0].startswith("2.csv: p_tp_pa: is 2")


def test_a_load_cell_at_the_end_of_its_range_in_half_of_the_files_rejects_their_runs(bring_in):
    loads = {"a": 300.0, "b": 300.0, "c": 800.0, "d": 800.0}
    logs = {name: log(n, load=f, full_scale=750.0) for n, (name, f) in enumerate(loads.items())}
    notes, reasons = bring_in(**logs)
    assert [bool(each) for each in reasons] == [False] * 4 + [True] * 4
    assert all("F_applied is constant at 750" in each[0] for each in reasons[4:])
    assert any("f_applied_n: is 750 N" in note for note in notes if "stuck" in note), notes


def test_a_regulated_pressure_and_an_idle_load_cell_are_not_accused(bring_in):
    files = {name: log(n, regulated=True, load=500.0 * (n > 1)) for n, name in enumerate("abc", 1)}
    notes, reasons = bring_in(**files)
    assert not any("stuck" in note for note in notes)
    assert not any("sensor_saturated" in reason for each in reasons for reason in each)

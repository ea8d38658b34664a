"""Values beyond the full scale of their instrument are noted: a unit or the full scale is wrong."""

import numpy as np
import pytest

from tests.support.strokes import there_and_back


@pytest.mark.parametrize(
    ("full_scale", "unit", "noted"),
    [
        ("2 kN", "N", ""),
        ("1.4 kN", "N", ""),  # load cells show some per cent more
        (
            "200 N",
            "N",
            "f_applied_n: up to 1507 N in size, beyond the instrument's full scale (200",
        ),
        (
            "20 kN",
            "kN",
            "f_applied_n: up to 1.507e+06 N in size, beyond the instrument's full scale",
        ),
    ],
)
def test_a_force_beyond_the_load_cells_full_scale_is_noted(
    rules, import_by, tmp_path, full_scale, unit, noted
):
    run = there_and_back(0.03, 1500.0, 1)
    channels = run["t_s"], run["x_m"], run["p_tp_pa"], run["p_tr_pa"], run["f_applied_n"]
    np.savetxt(tmp_path / "1.csv", np.stack(channels, axis=1), "%.5f", ",", header="t,x,A,B,F",
               comments="")  # fmt: skip
    rules["columns"] = {
        "t_s": {"column": "t", "unit": "s"},
        "x_m": {"column": "x", "unit": "m"},
        "p_tp_pa": {"column": "A", "unit": "Pa"},
        "p_tr_pa": {"column": "B", "unit": "Pa"},
        "f_applied_n": {"column": "F", "unit": unit},
    }
    rules["instruments"] = {
        "force": {"tolerance": "0.1 %", "full_scale": full_scale},
        "pressure": {"tolerance": "0.1 %", "full_scale": "250 bar"},
    }
    del rules["constants"]
    rules["series"][0]["files"] = "{trial}.csv"
    rules["cut"] = "reversals"
    _, notes = import_by(rules)
    found = [note for note in notes if "full scale" in note]
    assert len(found) == bool(noted)
    assert found == [] or noted in found[0] and "check its unit and scale" in found[0], found

"""Oil temperature of another bench's logs: from the file in degC to the reduced friction."""

import json
from datetime import UTC, datetime

import numpy as np
import pytest
import yaml

from hbench import workflow
from hbench.errors import ConfigError, DataError
from hbench.store.campaign.folder import load_campaign
from tests.support.analysis.warming import (
    MAP,
    SPEEDS,
    ZERO_K,
    Friction,
    data_sheet,
    order_of,
    warming,
    write_logs,
)

CLOCK = lambda: datetime(2026, 3, 1, tzinfo=UTC)  # noqa: E731
FEW = SPEEDS[[1, 4, 7, 9, 14]]
OIL = {
    "grade": "HLP 100",
    "density": "880 kg/m^3",
    "viscosity": {
        f"{t_k - ZERO_K:g} degC": f"{1e6 * nu} mm^2/s" for t_k, nu in data_sheet().viscosity.items()
    },
}


@pytest.fixture
def bring_in(tmp_path):
    """Return a function that imports the logs of ``runs`` with the map ``rules``."""

    def bring_in(runs, rules, **how):
        write_logs(tmp_path / "logs", runs, Friction(), np.random.default_rng(1), **how)
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
        workflow.import_runs(tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", CLOCK)
        return tmp_path / "out"

    return bring_in


def rules(**changes):
    return yaml.safe_load(MAP) | changes


def column(**changes):
    columns = rules()["columns"]
    return rules(columns=columns | {"temp_tank_k": columns["temp_tank_k"] | changes})


def test_a_temperature_in_degrees_celsius_becomes_kelvin(bring_in):
    folder = bring_in([(0.1, 1)], column(offset="-1.5 K"))
    (run,) = load_campaign(folder).runs()
    assert run.temp_tank_k.mean() == pytest.approx(warming(0) - 1.5, abs=0.05)


def test_the_report_shows_the_temperatures_and_the_reduced_friction(bring_in, undrawn):
    order = order_of("random", np.random.default_rng(2), speeds=FEW)
    folder = bring_in(order, rules(oil=OIL))
    results = workflow.report(folder, form="md")
    oil = results.oil_temperature
    assert oil.low_k == pytest.approx(warming(0), abs=0.5)
    assert {curve.direction for curve in oil.reduction.curves} == {"extend", "retract"}
    assert all(point.hersey_m > 0 for curve in results.curves for point in curve.points)
    text = (folder / "results" / "report.md").read_text()
    for words in (
        "Oil temperature in the tank: 34",
        "is reduced to 40.0 °C",
        "HLP 100",
        "Within the points, friction falls as the oil temperature rises",
        "Friction over Hersey number",
    ):
        assert words in text
    assert "Meanwhile the oil temperature" not in text  # the order is that of the files' names
    table = (folder / "results" / "curves_reduced.csv").read_text().splitlines()
    assert len(table) == 1 + 2 * len(FEW) and table[0].endswith("temp_ref_k,sigma_temperature_n")
    data = json.loads((folder / "results" / "results.json").read_text())
    assert data["oil_temperature"]["reduction"]["effects"][0]["determined"] is True
    assert data["curves"][0]["temp_range_k"][1] > data["curves"][0]["temp_range_k"][0]


def test_the_report_names_a_missing_viscosity_and_a_missing_sensor(bring_in, tmp_path, undrawn):
    folder = bring_in([(v, 1) for v in FEW], rules())
    workflow.report(folder, form="md")
    text = (folder / "results" / "report.md").read_text()
    assert "since the oil's viscosity is not known; give oil.viscosity at two temperatures" in text
    columns = {key: c for key, c in rules()["columns"].items() if key != "temp_tank_k"}
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules(columns=columns)))
    workflow.import_runs(tmp_path / "logs", tmp_path / "bare", tmp_path / "map.yaml", CLOCK)
    workflow.report(tmp_path / "bare", form="md")
    text = (tmp_path / "bare" / "results" / "report.md").read_text()
    assert "The oil temperature was not measured." in text and "Hersey" not in text


def test_a_temperature_that_was_read_once_is_a_constant(bring_in):
    columns = {key: c for key, c in rules()["columns"].items() if key != "temp_tank_k"}
    folder = bring_in([(0.1, 1)], rules(columns=columns, constants={"temp_port_k": "41.5 degC"}))
    (run,) = load_campaign(folder).runs()
    assert run.temp_port_k == pytest.approx(314.65)


@pytest.mark.parametrize(
    ("changed", "error", "message"),
    [
        (column(unit="bar"), ConfigError, "unit 'bar' is not one of K"),
        (column(offset="1 degC"), ConfigError, "a temperature, not a difference"),
        (column(zero="rest"), ConfigError, "zero: rest is not possible"),
        (column(unit="K"), DataError, "temp_tank_k is 34.* K; limit 193.15 K"),
    ],
)
def test_what_is_no_temperature_is_refused(bring_in, changed, error, message):
    with pytest.raises(error, match=message):
        bring_in([(0.1, 1)], changed)


@pytest.mark.parametrize(("every_s", "refused"), [(1.0, False), (70.0, True)])
def test_a_slow_logger_of_the_temperature_is_interpolated(tmp_path, every_s, refused):
    """Its own times, in the first rows of the file; the position has 100 Hz."""
    t = np.arange(0, 2.2 * every_s, 0.01 * every_s)
    slow = np.arange(0, 2.2 * every_s, every_s)
    rows = ["t,x,p_A,p_B,F,t_slow,T_oil"]
    for i, now in enumerate(t):
        row = f"{now:.2f},{100 * now / every_s:.4f},50,20,1000"
        rows.append(f"{row},{slow[i]:g},{40 + i:g}" if i < len(slow) else f"{row},,")
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs" / "1_100mms_1.csv").write_text("\n".join(rows) + "\n")
    (tmp_path / "map.yaml").write_text(
        yaml.safe_dump(column(time="t_slow") | {"screening": {"max_gap": "1 s"}})
    )
    arguments = tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", CLOCK
    if refused:
        with pytest.raises(DataError, match="temp_tank_k: 70 s between samples; limit 60 s"):
            workflow.import_runs(*arguments)
        return
    workflow.import_runs(*arguments)
    (run,) = load_campaign(tmp_path / "out").runs()
    # the run does not end with the last temperature
    assert run.t_s[-1] == pytest.approx(2.19)
    assert run.temp_tank_k == pytest.approx(ZERO_K + 40 + np.minimum(run.t_s, 2), abs=1e-6)

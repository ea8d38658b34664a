"""A bench with one cylinder and weights: no load cylinder, no load valves; see ``weight_bench``."""

from datetime import UTC, datetime

import pytest
import yaml

from hbench import workflow
from hbench.errors import ConfigError
from hbench.report.diagnosis.words.place import at_point_words
from tests.support.independent.weight_bench import write_weight_campaign

AT = datetime(2026, 1, 1, tzinfo=UTC)


def campaign(folder, leak_l_min_bar, seed):
    write_weight_campaign(folder, leak_l_min_bar, seed)
    workflow.import_runs(folder / "logs", folder / "campaign", folder / "map.yaml", lambda: AT)
    return folder


def reconciled(folder):
    return workflow.reconcile(folder / "campaign", folder / "model.yaml", lambda done, of: None)


@pytest.fixture(scope="module")
def leaking(tmp_path_factory):
    return campaign(tmp_path_factory.mktemp("leaking"), 0.006, seed=1)


@pytest.fixture(scope="module")
def found(leaking):
    return reconciled(leaking)


@pytest.mark.slow
def test_the_test_valves_command_and_pressures_show_a_leak(found):
    effects = {effect.name: effect.parameters for effect in found.effects}
    assert found.verdict == "named" and set(effects) == {"internal_leakage"}
    assert effects["internal_leakage"]["test"].value == pytest.approx(0.006, rel=0.25)
    assert not {"flow_lp", "flow_lr", "force_load"} & set(found.gap_heldout.balances)
    assert not [name for name in (*found.refitted, *effects["internal_leakage"]) if "load" in name]
    assert "load_cylinder" not in found.revised
    assert not [text for text in found.missing if "p_lp" in text or "flow_lp" in text]
    changed = {change.quantity for change in found.practice[0].changes}
    assert changed == {"flow_tp", "flow_tr", "speed"}
    text = at_point_words(found.working_point, found.practice[0])
    assert "oil" in text and "changes nothing" not in text


@pytest.mark.slow
def test_a_tight_cylinder_has_no_effect(tmp_path):
    assert not reconciled(campaign(tmp_path, 0.0, seed=2)).effects


def test_a_model_without_a_load_cylinder_is_refused_if_a_log_has_its_pressure(leaking, tmp_path):
    rules = yaml.safe_load((leaking / "map.yaml").read_text())
    rules["constants"] = {"p_lp_pa": "10 bar"}
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
    workflow.import_runs(leaking / "logs", tmp_path / "campaign", tmp_path / "map.yaml", lambda: AT)
    (tmp_path / "model.yaml").write_text((leaking / "model.yaml").read_text())
    with pytest.raises(ConfigError, match="load_cylinder") as error:
        reconciled(tmp_path)
    assert "no pressures of a load cylinder" in error.value.hint


def test_strokes_are_compared_where_the_model_has_no_valve(leaking):
    model = yaml.safe_load((leaking / "model.yaml").read_text())
    short = {
        "test_cylinder": model["test_cylinder"],
        "friction": {"test": model["friction"]["test"]},
    }
    (leaking / "strokes.yaml").write_text(yaml.safe_dump(short))
    found = workflow.reconcile(
        leaking / "campaign", leaking / "strokes.yaml", lambda done, of: None
    )
    assert "loads or pressures with two or more strokes" in found.why


@pytest.mark.slow
def test_uneven_times_give_the_same_verdict(leaking, found, tmp_path):
    (tmp_path / "logs").mkdir()
    for path in (leaking / "logs").iterdir():
        head, *rows = path.read_text().splitlines()
        kept = [row for i, row in enumerate(rows) if i % 7]
        (tmp_path / "logs" / path.name).write_text("\n".join([head, *kept, ""]))
    for name in ("map.yaml", "model.yaml"):
        (tmp_path / name).write_text((leaking / name).read_text())
    workflow.import_runs(
        tmp_path / "logs", tmp_path / "campaign", tmp_path / "map.yaml", lambda: AT
    )
    uneven = reconciled(tmp_path)
    assert not uneven.left_out and uneven.verdict == found.verdict == "named"
    assert [one.name for one in uneven.effects] == [one.name for one in found.effects]


@pytest.mark.slow
def test_a_supply_pressure_that_is_a_constant_of_the_map_is_not_compared(leaking, tmp_path):
    rules = yaml.safe_load((leaking / "map.yaml").read_text())
    del rules["columns"]["p_s_pa"]
    rules |= {"constants": {"p_s_pa": "140 bar"}, "resample": "50 Hz"}
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
    workflow.import_runs(leaking / "logs", tmp_path / "campaign", tmp_path / "map.yaml", lambda: AT)
    (tmp_path / "model.yaml").write_text((leaking / "model.yaml").read_text())
    found = reconciled(tmp_path)
    assert {effect.name for effect in found.effects} == {"internal_leakage"}
    assert "supply" not in found.gap_heldout.balances and found.gap_heldout.total.after < 10

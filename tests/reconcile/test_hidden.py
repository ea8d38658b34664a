"""The generator of blind campaigns: what it takes, what it lists."""

import ast
from pathlib import Path

from hidden.cases import cases, small_sample, truth
from hidden.sizes import KNOWN, OUTSIDE

from hbench.model.effects import EFFECTS

FOLDER = Path(__file__).parent / "hidden"
CATALOGUE = {f"hbench.model.effect_{name}" for name in ("flows", "friction", "numbers")}


def imported(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


def test_the_hidden_plants_do_not_import_the_catalogues_laws():
    files = sorted(FOLDER.rglob("*.py"))
    assert len(files) > 8
    for path in files:
        found = set(imported(path))
        assert not found & (CATALOGUE | {"hbench.model.effects.EFFECTS", "hbench.reconcile"}), path


def test_what_diagnoses_can_list_the_cases_without_their_laws():
    for name in ("cases", "draws", "sizes"):
        assert not any(m.startswith("hbench") for m in imported(FOLDER / f"{name}.py"))


def test_the_cases_are_those_that_the_benchmark_needs():
    listed = cases()
    assert len({case.name for case in listed}) == len({case.seed for case in listed}) == len(listed)
    groups = {group: [c for c in listed if c.group == group] for group in ("single", "none")}
    assert set(KNOWN) == set(EFFECTS)
    for name in KNOWN:
        for severity in (0.5, 1.0, 2.0):
            assert [c.effects for c in groups["single"]].count({name: severity}) >= 3
    assert len(groups["single"]) >= 200 and len(groups["none"]) >= 60
    assert sum(c.group == "pair" for c in listed) >= 24
    outside = [c for c in listed if c.group == "outside"]
    assert len(outside) >= 24 and len({name for c in outside for name in c.effects}) >= 6
    assert not set(OUTSIDE) & set(EFFECTS)
    assert {case.group for case in small_sample()} == {"single", "none", "pair", "outside"}


def test_sizes_follow_the_severity_and_the_seed_alone():
    for case in cases():
        for name, found in truth(case).effects.items():
            size = (KNOWN | OUTSIDE)[name]
            amounts = {key: value for key, value in found.items() if key in size.amounts}
            shares = [v / size.amounts[key] / case.effects[name] for key, v in amounts.items() if v]
            assert shares and all(0.8 <= abs(share) <= 1.2 for share in shares)
            assert size.signed or min(shares) > 0
        assert truth(case) == truth(case)

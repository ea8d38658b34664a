"""The drawing of the hydraulic circuit in the README."""

import re
import sys

from tests.conftest import ROOT


def test_the_drawing_names_the_symbols_that_the_readme_explains(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "data_samples")
    import circuit

    drawn = " ".join(text.get_text() for text in circuit.draw().axes[0].texts)
    drawn = re.sub(r"\\mathrm|[{}$ ]", "", drawn)
    rows = re.findall(
        r"^\| (`.*?) \|", (ROOT / "README.md").read_text().split("## The bench")[1], re.M
    )
    symbols = set(re.findall(r"`(\w+)`", " ".join(rows[:8]))) - {"p_lr"}  # a reference, no place
    assert {"x", "v", "P_Tp", "P_Lr", "P_S", "F_applied", "F_L", "u_l2"} <= symbols
    assert {symbol for symbol in symbols if symbol not in drawn} == set()
    sys.modules.pop("circuit")

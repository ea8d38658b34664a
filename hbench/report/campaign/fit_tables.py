"""The page's tables of fits: parameters of each law, and how well laws predict unseen speeds."""

import math
import re

from hbench.records import Fit, FitParameter, Results, Selection
from hbench.records.rod_pressure import without_common_rod_pressure
from hbench.report.campaign.page_tables import WHO, table, who, who_text
from hbench.report.render.numbers import significant, with_ends
from hbench.report.render.word_tables import Cell, Table
from hbench.units import from_si

# How a law's parameters read on the page: words and the unit to show. Others keep their names.
PARAMETERS = {
    "f_coulomb_n": ("Coulomb force F_C", "N"),
    "f_stiction_n": ("Stiction force F_stiction", "N"),
    "v_stribeck_m_s": ("Stribeck velocity", "mm/s"),
    "b_viscous_n_s_m": ("Viscous coefficient B", "N s/m"),
    "low_force_n": ("Force at rest a_1", "N"),
    "low_slope_n_s_m": ("Slope below v_SW", "N s/m"),
    "high_slope_n_s_m": ("Slope above v_SW", "N s/m"),
    "v_switch_m_s": ("Switch velocity v_SW", "mm/s"),
    "k1_n": ("k_1", "N"),
    "k2_s_m": ("k_2", "s/m"),
    "k3_n_pa": ("k_3", "N/bar"),
    "k4_n_pa": ("k_4", "N/bar"),
    "k5_n_s_m": ("k_5", "N s/m"),
}
LAWS = {
    "tustin": "Tustin",
    "marton_lantos": "Marton and Lantos",
    "pressure_based": "Pressure-based",
    "lugre": "LuGre",
    "leuven": "Leuven",
}
_ALL = "all loads and directions"


def fit_tables(results: Results) -> dict[str, Table]:
    """Return a table of parameters for each law, with its messages below."""
    fits = [
        (who(c), who_text(c), fit)
        for c in without_common_rod_pressure(results.curves)
        for fit in c.fits
    ]
    for joint in results.joint_fits:
        words = ", ".join(filter(None, (joint.label, _ALL)))
        fits += [((joint.label, "", _ALL, "all", ""), words, fit) for fit in joint.fits]
    tables = {}
    for law in dict.fromkeys(fit.law for _, _, fit in fits):
        chosen = [one for one in fits if one[2].law == law]
        names = list(dict.fromkeys(name for _, _, fit in chosen for name in fit.parameters))
        units = {name: fit.parameters[name].unit for *_, fit in chosen for name in fit.parameters}
        heads = [_parameter_head(name, units[name]) for name in names]
        rows: list[tuple[str | Cell, ...]] = []
        for columns, _, fit in chosen:
            cells = [_parameter_cell(name, fit.parameters.get(name)) for name in names]
            rows.append((*columns, *cells, _residual_cell(fit)))
        told: dict[str, list[str]] = {}
        for _, words, fit in chosen:
            if fit.message:
                told.setdefault(fit.message, []).append(words)
        messages = [f"{'; '.join(words)}: {in_words(message)}" for message, words in told.items()]
        tables[law] = table((*WHO, *heads, "RMS residual (N)"), rows, messages)
    return tables


def selection_table(results: Results) -> Table:
    """Return how well laws predict speeds left out of their fits."""
    chosen = [(who(c), c.selection) for c in without_common_rod_pressure(results.curves)]
    chosen += [((j.label, "", _ALL, "all", ""), j.selection) for j in results.joint_fits]
    rows = [(*columns, *_selected(found)) for columns, found in chosen if found is not None]
    head = ("Best law", "Next", "Difference (N²)", "s.e. (N²)", "Remark")
    return table((*WHO, *head), rows, words=("Best law", "Next"))


def _selected(found: Selection) -> tuple[str, ...]:
    best, following = (
        f"{law_words(one.law)} ({significant(one.rmse_n, 3)} N)" for one in found.laws[:2]
    )
    verdict = "told apart" if found.told_apart else "not told apart"
    return (
        best,
        following,
        significant(found.difference_n2, 3),
        significant(found.difference_se_n2, 2),
        f"{verdict} by {found.speeds} speeds",
    )


def law_words(law: str) -> str:
    """Return what a friction law is called; one that is not in the table keeps its name."""
    return LAWS.get(law, law.replace("_", " "))


def in_words(text: str) -> str:
    """Write parameters of laws in a sentence by what they are called, not by their keys."""
    for name, (words, _) in PARAMETERS.items():
        text = re.sub(rf"\b{name}\b", words, text)
    return text


def _parameter_head(name: str, unit: str) -> str:
    words, shown = PARAMETERS.get(name, (name, unit))
    return f"{words} ({shown})"


def _parameter_cell(name: str, parameter: FitParameter | None) -> Cell:
    if parameter is None:
        return Cell("")
    shown = PARAMETERS[name][1] if name in PARAMETERS else "1"
    value = from_si(parameter.value, shown)
    text, flag = significant(value, 3), "not determined"
    if parameter.ci95 is not None and all(map(math.isfinite, parameter.ci95)):
        low, high = (from_si(end, shown) for end in parameter.ci95)
        text, flag = with_ends(value, low, high), ""
    return Cell(text, flag if parameter.at_bound is None else f"at {parameter.at_bound} bound")


def _residual_cell(fit: Fit) -> Cell:
    return Cell(significant(fit.rmse_n, 3), "" if fit.converged else "not converged")

"""Tables: the fixed shape of results.json, numbers that don't exist, and CSV read by pandas."""

import io
import json
import re
from dataclasses import asdict, astuple, replace

import numpy as np
import pandas as pd
import pytest

from hbench.records import Results, WordTable
from hbench.report.campaign import page_tables
from hbench.report.campaign.csv_motions import MOTION_TABLES
from hbench.report.campaign.csv_tables import (
    TABLES,
    band_trends_csv,
    bands_csv,
    covariances_csv,
    curves_csv,
    efficiency_csv,
    fits_csv,
    runs_csv,
)
from hbench.report.campaign.fit_tables import correlation_table
from hbench.report.campaign.results_document import results_json
from hbench.report.campaign.terminal import summary_text
from hbench.report.first_sheet import about_rows
from hbench.report.headline import headline_words
from hbench.report.render.numbers import with_ends, with_minus, without_powers
from hbench.report.render.pdf_pen import Pen, width_of, words_of
from hbench.report.render.pdf_table import set_table
from hbench.report.render.terminal_table import table_lines
from hbench.report.render.terminal_text import plain
from hbench.report.setting_words import value_words

NUMBER = (int, float)
MAYBE = (int, float, type(None))
RUN = {
    "run": str,
    "kind": str,
    "direction": str,
    "v_ref_m_s": NUMBER,
    "f_load_n": MAYBE,
    "trial": int,
    "accepted": bool,
    "reason": (str, type(None)),
    "v_mean_m_s": MAYBE,
    "friction_n": MAYBE,
    "efficiency": MAYBE,
}
SERIES = {"kind": str, "direction": str, "f_load_n": MAYBE, "points": list}
POINT = {"v_m_s": NUMBER, "friction_n": NUMBER, "ci95_n": MAYBE, "n": int}
FIT = {"law": str, "parameters": dict, "rmse_n": NUMBER, "converged": bool, "message": str}
PARAMETER = {
    "value": NUMBER,
    "se": MAYBE,
    "bias": MAYBE,
    "ci95": (list, type(None)),
    "at_bound": (str, type(None)),
}
EFFICIENCY = {"v_m_s": NUMBER, "efficiency": MAYBE, "sigma": MAYBE}


def holds(item, shape):
    for name, kinds in shape.items():
        assert name in item
        assert isinstance(item[name], kinds), (name, item[name])


def refuse_constant(name):
    raise AssertionError(f"{name} is not JSON")


def parsed(results):
    return json.loads(results_json(results), parse_constant=refuse_constant)


def read(text):
    return pd.read_csv(io.StringIO(text), keep_default_na=True)


def with_point(results, **changes):
    curve = results.curves[0]
    point = replace(curve.points[0], **changes)
    curve = replace(curve, points=(point, *curve.points[1:]))
    return replace(results, curves=(curve, *results.curves[1:]))


@pytest.mark.parametrize("name", ["stribeck", "seals"])
def test_results_json_has_the_names_and_types_that_other_programs_read(name, request):
    results: Results = request.getfixturevalue(name)
    document = parsed(results)
    assert document["schema"] == "hbench.results/1"
    assert len(document["runs"]) == len(results.runs)
    for run in document["runs"]:
        holds(run, RUN)
        assert run["direction"] in ("extend", "retract")
        assert run["accepted"] == (run["reason"] is None)
    for curve in document["curves"]:
        holds(curve, {**SERIES, "fits": list})
        for point in curve["points"]:
            holds(point, POINT)
        for fit in curve["fits"]:
            holds(fit, FIT)
            for parameter in fit["parameters"].values():
                holds(parameter, PARAMETER)
                assert parameter["at_bound"] in (None, "lower", "upper")
    for curve in document["efficiency"]:
        holds(curve, SERIES)
        for point in curve["points"]:
            holds(point, EFFICIENCY)


def test_tustin_parameters_carry_their_fixed_names(stribeck):
    fit = parsed(stribeck)["curves"][0]["fits"][0]
    assert set(fit["parameters"]) == {
        "f_coulomb_n",
        "f_stiction_n",
        "v_stribeck_m_s",
        "b_viscous_n_s_m",
    }
    assert fit["parameters"]["f_coulomb_n"]["at_bound"] == "lower"


def test_a_number_that_does_not_exist_is_null_in_json_and_empty_in_csv(stribeck):
    results = with_point(stribeck, friction_n=float("nan"), ci95_n=None, p_tr_pa=float("inf"))
    point = parsed(results)["curves"][0]["points"][0]
    assert point["friction_n"] is None and point["ci95_n"] is None and point["p_tr_pa"] is None
    cells = curves_csv(results).splitlines()[1].split(",")
    header = curves_csv(results).splitlines()[0].split(",")
    assert [cells[header.index(n)] for n in ("friction_n", "ci95_n", "p_tr_pa")] == ["", "", ""]


def test_a_rejected_run_without_a_window_keeps_its_reason_and_has_no_numbers(stribeck):
    runs = [run for run in parsed(stribeck)["runs"] if "truncated" in (run["reason"] or "")]
    assert runs
    for run in runs:
        assert run["friction_n"] is None and run["v_mean_m_s"] is None
        assert run["reason"] == "; ".join(run["reasons"])


def test_provenance_with_numpy_values_and_odd_types_becomes_json(stribeck):
    details = {"seed": np.int64(3), "limits": np.array([1.0, np.nan]), 5: {"a": {1}}, "x": (1, 2)}
    results = replace(stribeck, provenance=replace(stribeck.provenance, details=details))
    got = parsed(results)["provenance"]["details"]
    assert got == {"seed": 3, "limits": [1.0, None], "5": {"a": "{1}"}, "x": [1, 2]}


def test_csv_numbers_come_back_exactly(stribeck):
    points = [point for curve in stribeck.curves for point in curve.points]
    table = read(curves_csv(stribeck))
    assert table["friction_n"].tolist() == [point.friction_n for point in points]
    assert table["v_m_s"].tolist() == [point.v_m_s for point in points]
    assert table["n"].tolist() == [point.n for point in points]
    runs = read(runs_csv(stribeck))
    assert runs["v_ref_m_s"].tolist() == [run.run.plan.v_ref_m_s for run in stribeck.runs]
    assert runs["accepted"].tolist() == [run.accepted for run in stribeck.runs]


def test_fits_csv_has_a_row_for_each_parameter_and_names_the_active_bound(stribeck):
    table = read(fits_csv(stribeck))
    assert len(table) == 4 * len(stribeck.curves)
    bound = table[table["at_bound"].notna()]
    assert bound[["parameter", "at_bound", "value"]].values.tolist() == [
        ["f_coulomb_n", "lower", 0.0]
    ]
    assert bound["ci95_low"].isna().all()


def test_covariances_are_in_json_csv_and_page_and_empty_at_a_bound(stribeck):
    names = ("f_coulomb_n", "b_viscous_n_s_m")
    covariance = {names[0]: {names[0]: 25.0, names[1]: -594.0}}
    covariance[names[1]] = {names[0]: -594.0, names[1]: 14400.0}
    unknown = {a: dict.fromkeys(names) for a in names}
    first, second, *others = stribeck.curves
    changed = [
        replace(curve, fits=(replace(curve.fits[0], covariance=matrix, dof=11),))
        for curve, matrix in ((first, unknown), (second, covariance))
    ]
    made = replace(stribeck, curves=(*changed, *others))
    table = read(covariances_csv(made))
    assert table[["parameter", "with_parameter"]].values.tolist()[:3] == [
        [names[0], names[0]], [names[0], names[1]], [names[1], names[1]]
    ]  # fmt: skip
    assert table["covariance"].isna().tolist() == [True] * 3 + [False] * 3
    assert table["correlation"].tolist()[3:] == [1.0, pytest.approx(-0.99), 1.0]
    assert table["unit"].tolist()[:3] == ["N * N", "N * N s/m", "N s/m * N s/m"]
    fits = [curve["fits"][0] for curve in parsed(made)["curves"][:2]]
    assert [pair["covariance"] for pair in fits[0]["covariances"]] == [None] * 3
    assert fits[1]["covariances"][1]["correlation"] == pytest.approx(-0.99)
    shown = correlation_table(made, "tustin")
    assert shown.head[-1] == "corr(F_C, B)"
    assert [row[-1].text for row in shown.rows] == ["−0.990"]
    assert correlation_table(stribeck, "tustin").rows == ()


def test_efficiency_csv_has_a_row_for_each_point(stribeck):
    assert len(read(efficiency_csv(stribeck))) == sum(len(c.points) for c in stribeck.efficiency)


def test_every_table_holds_the_rod_side_pressure_of_its_curve(two_rod_sides):
    for key in ("curves", "efficiency"):
        found = [curve["p_lr_ref_pa"] for curve in parsed(two_rod_sides)[key]]
        assert found == [15e5] * 4 + [60e5] * 4
    for table in (curves_csv, fits_csv, efficiency_csv):
        assert set(read(table(two_rod_sides))["p_lr_ref_pa"]) == {15e5, 60e5}
    assert "500 N, 60 bar" in summary_text(two_rod_sides)


def test_bands_stand_in_json_and_csv(seals):
    names = (
        "kind label f_load_n p_lr_ref_pa v_m_s p_tp_pa half_n half_ci95_n "
        "middle_n middle_ci95_n energy_j energy_ci95_j n"
    ).split()
    for document, band in zip(parsed(seals)["bands"], seals.bands, strict=True):
        assert {name: document[name] for name in names} == {n: getattr(band, n) for n in names}
        assert document["trials_half_n"] == list(band.trials_half_n)
    table = read(bands_csv(seals))
    assert list(table) == names
    assert table["half_n"].tolist() == [band.half_n for band in seals.bands]
    assert table["half_ci95_n"].isna().tolist() == [False] * 4 + [True] * 4


def test_a_series_over_pressure_has_a_line_for_half_band_and_middle_in_json_and_csv(seals):
    documents, table = parsed(seals)["band_trends"], read(band_trends_csv(seals))
    assert [document["label"] for document in documents] == ["O-ring", "NAPN"]
    assert table["quantity"].tolist() == ["half", "middle"] * 2
    assert table["p_low_pa"].tolist() == [1e5] * 4 and table["p_high_pa"].tolist() == [7e5] * 4
    for trend, document in zip(seals.band_trends, documents, strict=True):
        for quantity in ("half", "middle"):
            line = getattr(trend, quantity)
            assert document[quantity] == asdict(line)
            chosen = (table["label"] == trend.label) & (table["quantity"] == quantity)
            (slope,) = table["slope_n_pa"][chosen]
            assert slope == line.slope_n_pa


def test_the_terminal_shows_bands_and_their_slopes(seals):
    text = summary_text(seals)
    assert text.isascii()
    slope, interval = (1e5 * x for x in astuple(seals.band_trends[0].half)[:2])
    assert f"{slope:.2f} +- {interval:.2f}" in text
    bands = [line for line in text.splitlines() if line.startswith("NAPN") and "extend" not in line]
    assert len([line for line in bands if line.endswith("  1")]) == 4  # one trial each


@pytest.mark.parametrize("lead", ["=", "+", "-", "@", "\t", "\r"])
def test_text_that_a_spreadsheet_would_run_is_made_text(stribeck, lead):
    hostile = lead + 'HYPERLINK("http://x";"y"),\n"'
    curve = replace(stribeck.curves[0], label=hostile)
    table = read(curves_csv(replace(stribeck, curves=(curve,))))
    assert table["label"][0].startswith("'")
    assert table["label"][0][1:].replace("\r", "\n") == hostile.replace("\r", "\n")
    # Negative numbers stay numbers.
    assert read(curves_csv(stribeck))["v_m_s"].min() == pytest.approx(-0.2)


@pytest.mark.usefixtures("wide_terminal")
def test_the_summary_shows_the_intervals_of_trials_and_instruments(stribeck):
    curve = stribeck.curves[0]
    points = [replace(p, ci95_n=None, u95_n=None) for p in curve.points]
    points[0] = replace(curve.points[0], friction_n=512.345, ci95_n=3.14, u95_n=None)
    points[1] = replace(curve.points[1], ci95_n=41.2, u95_n=66.6)

    def cells(*points):
        curves = (replace(curve, points=tuple(points)),)
        lines = (
            summary_text(replace(stribeck, curves=curves)).partition("\n\n")[2].splitlines()[1:3]
        )
        return [re.split(r"  +", line)[3:6] for line in lines]

    head, found = cells(*points[:3])
    assert head == ["friction N", "trials +- N", "U +- N"]
    assert found[1:] == ["3.1 to 41 (2 of 3)", "67 (1 of 3)"]
    assert cells(*points[:2])[1][1:] == ["3.1 to 41", "67 (1 of 2)"]
    assert cells(points[0]) == [["friction N", "trials +- N"], ["512.3", "3.1"]]
    assert cells(*points[2:4])[0][1:2] == []  # nothing is known


def test_the_summary_names_counts_reasons_and_bounds_in_plain_ascii(stribeck):
    text = summary_text(stribeck)
    assert text.isascii()
    together = " ".join(text.split())
    assert re.search(r"\b360 runs: 352 \w+, 8 \w+ \(2 off reference\b", together)
    assert "Tustin fits (-: not determined; " in text and "_n=" not in text
    assert re.search(r"^direction +load +F_C N +F_s N +v_s mm/s +B N s/m$", text, re.MULTILINE)
    assert "Next step: " in together and "[[" not in text
    stiction = stribeck.curves[0].fits[0].parameters["f_stiction_n"]
    assert plain(with_ends(stiction.value, *stiction.ci95)) in together
    assert plain(headline_words(stribeck).replace("–", " to ")) in together
    assert "PASS" not in text
    assert "PASS by the last hbench accept. " in summary_text(stribeck, "PASS")
    assert max(map(len, text.splitlines())) <= 80
    rows = [line for line in text.splitlines() if line.startswith(("extend", "retract"))]
    assert len(rows) == 2 * 8  # of the curves, and of their fits


@pytest.mark.parametrize(
    ("campaign", "series", "write"),
    [
        ("small", "curves", curves_csv),
        ("small", "curves", fits_csv),
        ("small", "efficiency", efficiency_csv),
        ("seals", "bands", bands_csv),
    ],
)
def test_factors_have_a_column_in_every_table_of_series(request, campaign, series, write):
    """Series without them have empty cells."""
    results = request.getfixturevalue(campaign)
    first, *others = getattr(results, series)
    made = replace(results, **{series: (replace(first, factors=(("oil", "HLP 46"),)), *others)})
    table = pd.read_csv(io.StringIO(write(made)))
    assert table.columns[list(table.columns).index("label") + 1] == "factor_oil"
    assert table["factor_oil"].iloc[0] == "HLP 46" and table["factor_oil"].isna().any()
    assert "factor_oil" not in write(results)


def test_settings_and_reasons_have_powers_of_ten_and_minus_signs():
    assert value_words("1.25e-5 V/(Pa s)") == "1.25·10⁻⁵ V/(Pa s)"
    assert value_words(6.5e-05) == "6.5·10⁻⁵"
    assert without_powers("6.5·10⁻⁵ V; 1·10², 2 mm²") == "6.5e-5 V; 1e2, 2 mm²"
    assert value_words("-10 V") == "−10 V"
    assert value_words("20 mm^2") == "20 mm²"
    for kept in ("2026-01-05", "1e2-file", "NBR-70", "44dee5e123"):
        assert value_words(kept) == kept
    assert with_minus("u_L2 is at its minimum, -10.0 V; 1-2") == (
        "u_L2 is at its minimum, −10.0 V; 1-2"
    )


def test_the_first_sheet_of_a_workbook_describes_every_table(stribeck):
    names = [name.removesuffix(".csv") for name in (*TABLES, *MOTION_TABLES) if ".csv" in name]
    described = {row[0] for row in about_rows(stribeck, names) if len(row) == 2}
    assert set(names) <= described


def test_a_tables_columns_are_aligned_on_a_terminal_where_some_cells_have_an_interval():
    rows = (("a", "1.0 ± 0.1", "one"), ("b", "1.0", "two"))
    _, head, *lines = table_lines(WordTable("", ("name", "value", "word"), rows))
    assert [line.index(word) for line, word in zip(lines, ("one", "two"), strict=True)] == [
        head.index("word")
    ] * 2
    assert "1.0 +- 0.1" in lines[0]


def test_a_table_too_wide_for_a_terminal_follows_below_itself_with_the_names_of_its_rows():
    rows = tuple(
        (name, *(f"{10 * i}.5 N s/m per bar" for i in range(6)), "a remark of a few words")
        for name in ("one", "two")
    )
    head = ("name", *(f"column_{i}" for i in range(6)), "remark")
    title, *lines = table_lines(WordTable("Title", head, rows))
    assert title == "Title"
    assert max(map(len, lines)) <= 80
    assert sum(line.startswith("name") for line in lines) >= 2
    for row in rows:
        shown = " ".join(" ".join(line for line in lines if line.startswith(row[0])).split())
        assert all(cell in shown for cell in row[:-1])


def test_words_of_a_table_are_broken_over_lines_and_numbers_are_not():
    words = "not significant because of a drift that the order of the runs does not separate"
    rows = (("extending, 500 N", "496 ± 90", words), ("retracting, -500 N", "7 ± 1.5", "none"))
    _, head, *lines = table_lines(WordTable("", ("curve", "A ± U", "verdict"), rows))
    assert max(map(len, lines)) <= 80 and len(lines) > 2
    assert "496 +- 90" in lines[0] and "extending, 500 N" in lines[0]
    at = head.index("verdict")
    said = " ".join(line[at:].strip() for line in lines[:-1])
    assert said == words


def test_the_decimal_points_of_a_column_are_aligned():
    rows = tuple(
        (name, value) for name, value in zip("abcd", ("0.12", "-13.4", "7", "–"), strict=True)
    )
    _, _, *lines = table_lines(WordTable("", ("name", "force (N)"), rows))
    a, b, c, d = lines
    assert a.index(".") == b.index(".") == c.index("7") + 1 == d.index("-") + 1


def test_a_column_of_several_units_is_not_aligned_at_its_points():
    rows = (("velocity", "800 V/m"), ("rod pressure", "1.25·10⁻⁵ V/(Pa s)"))
    _, _, *lines = table_lines(WordTable("", ("loop", "gain"), rows))
    assert lines == ["velocity      800 V/m", "rod pressure  1.25e-5 V/(Pa s)"]


def test_a_unit_in_a_narrow_head_stays_on_a_line():
    for head, pieces in (
        (
            "U = 1.96 u (% points)",
            ["U", "=\N{NO-BREAK SPACE}1.96", "u", "(%\N{NO-BREAK SPACE}points)"],
        ),
        ("Breakaway ± U (bar)", ["Breakaway", "±\N{NO-BREAK SPACE}U", "(bar)"]),
    ):
        assert words_of(head) == pieces


def test_a_bold_row_of_a_pdf_takes_no_room_from_rows_that_need_it():
    """One short bold row leaves the plain rows as they are."""
    rows = [["a quantity with a long name at 100 bar", "NOT TESTED"]] * 4 + [["short", "PASS"]]
    broken = []
    for bold in ((), (4,)):
        pen = Pen()
        pen.width = 7.2 * sum(width_of(cell, "normal") for cell in rows[0]) + 10
        set_table(pen, ("Quantity", "Decision"), rows, (), bold=bold)
        broken.append([text.get_text() for text in pen.done[0].texts])
    assert broken[0] == broken[1] and rows[0][0] in broken[0]


def test_runs_with_the_same_remark_have_one_row(small):
    accepted = [run for run in small.runs if run.accepted]
    same = [replace(run, notes=("the reference was not logged",)) for run in accepted[:3]]
    own = replace(accepted[3], notes=("another",))
    found = page_tables.remark_table(replace(small, runs=(*same, own, *accepted[4:])))
    remark, trial = map(found.head.index, ("Remark", "Trial"))
    (shared, single) = [[cell.text for cell in row] for row in found.rows]
    assert shared[0] == f"{same[0].run.plan.run} and 2 others"
    assert (shared[remark], single[remark]) == ("the reference was not logged", "another")
    trials = {run.run.plan.trial for run in same}
    assert shared[trial] == (str(*trials) if len(trials) == 1 else "several")
    assert single[0] == own.run.plan.run

"""Tables of fits for the page: parameters of each law, and errors at held-out speeds."""

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations

from hbench.records import Fit, FitParameter, Results, Selection
from hbench.records.friction_laws import FRICTION_LAWS, PARAMETERS
from hbench.records.rod_pressure import without_common_rod_pressure
from hbench.report.campaign.table_columns import WHO, table, who, who_text
from hbench.report.render.numbers import NONE, half_width, number, significant, span, with_ends
from hbench.report.render.word_tables import Cell, Table
from hbench.sentences import capital, listed
from hbench.units import from_si

_ALL = "all loads and directions"


def fit_tables(results: Results) -> dict[str, Table]:
    """Return a table of parameters for each law."""
    fits = _fits(results)
    tables = {}
    for law in dict.fromkeys(fit.law for _, _, fit in fits):
        chosen = [row for row in fits if row[2].law == law]
        names = list(dict.fromkeys(name for _, _, fit in chosen for name in fit.parameters))
        units = {name: fit.parameters[name].unit for *_, fit in chosen for name in fit.parameters}
        heads = [_parameter_head(name, units[name]) for name in names]
        rows: list[tuple[str | Cell, ...]] = []
        for columns, _, fit in chosen:
            known = {} if determines_none(fit) else fit.parameters
            cells = [parameter_cell(name, known.get(name)) for name in names]
            rows.append((*columns, *cells, _residual(fit), _verdict_cell(fit)))
        head = (*WHO, *heads, "RMS residual (N)", "Verdict")
        title = f"{law_words(law)}: fitted parameters"
        tables[law] = replace(table(head, rows, words=("Verdict",)), title=title)
    return tables


def remark_table(results: Results, law: str) -> Table:
    """Return a row for each remark on a law's fits; fits with the same remark share a row."""
    series_of: dict[str, list[str]] = {}
    for _, series, fit in _fits(results):
        if fit.law == law and fit.message:
            for remark in fit.message.split("; "):
                series_of.setdefault(remark, []).append(series)
    rows = [
        (Cell("; ".join(series)), Cell(f"{capital(_with_symbols(remark)).rstrip('.')}."))
        for remark, series in sorted(series_of.items(), key=lambda item: item[1])
    ]
    head = ("Fit", "Remark")
    return Table(head, tuple(rows), frozenset(head), title=f"{law_words(law)}: remarks on the fits")


def correlation_table(results: Results, law: str) -> Table:
    """Return the correlation of each pair of a law's parameters; no rows where none is known."""
    rows: list[tuple[str, ...]] = []
    pairs: list[tuple[str, str]] = []
    for columns, _, fit in _fits(results):
        known = any(pair.correlation is not None for pair in fit.covariances)
        if fit.law == law and known:
            pairs = list(combinations(fit.covariance, 2))
            correlation = fit.correlation
            rows.append((*columns, *(number(correlation[a][b], 3) for a, b in pairs)))
    heads = (f"corr({_symbol(a)}, {_symbol(b)})" for a, b in pairs)
    return replace(table((*WHO, *heads), rows), title="Correlation of the parameters")


def _fits(results: Results) -> list[tuple[tuple[str, ...], str, Fit]]:
    """Return each fit with its series in the columns ``WHO`` and as text."""
    fits = [
        (who(c), who_text(c), fit)
        for c in without_common_rod_pressure(results.curves)
        for fit in c.fits
    ]
    for joint in results.joint_fits:
        series = ", ".join(filter(None, (joint.label, _ALL)))
        fits += [((joint.label, "", _ALL, "all", ""), series, fit) for fit in joint.fits]
    return fits


def _symbol(name: str) -> str:
    return PARAMETERS[name].symbol if name in PARAMETERS else name


def verdict_words(fit: Fit) -> str:
    """Write a fit's verdict, such as ``F_C, v_s not determined``."""
    if determines_none(fit):
        return "none determined"
    graded = (("not determined", fit.undetermined), ("hardly determined", fit.hardly_determined))
    if fit.verdict == "not converged" or not any(names for _, names in graded):
        return fit.verdict
    return "; ".join(f"{', '.join(map(_symbol, names))} {how}" for how, names in graded if names)


def determines_none(fit: Fit) -> bool:
    """Return whether no parameter of a fit has an interval, as with as many points as parameters.

    Their values are of no use to a reader; results.json contains them.
    """
    return (
        bool(fit.parameters)
        and set(fit.undetermined) == set(fit.parameters)
        and all(
            parameter.ci95 is None and parameter.at_bound is None
            for parameter in fit.parameters.values()
        )
    )


def fits_verdict(results: Results) -> str:
    """Return the verdicts on the fits of each law in a sentence or two; empty without fits."""
    verdicts = results.fit_verdicts
    if not verdicts:
        return ""
    determined = (f"{law_words(law.law)} {law.determined} of {law.fits}" for law in verdicts)
    failed = [
        f"{law_words(law.law)} {law.not_converged} of {law.fits}"
        for law in verdicts
        if law.not_converged
    ]
    text = f"Fits with all parameters determined: {', '.join(determined)}."
    return f"{text} Not converged: {', '.join(failed)}." if failed else text


def selection_table(results: Results) -> Table:
    """Return the laws' errors at held-out speeds."""
    chosen = [(who(c), c.selection) for c in without_common_rod_pressure(results.curves)]
    chosen += [((j.label, "", _ALL, "all", ""), j.selection) for j in results.joint_fits]
    rows = [
        (*columns, *_selected(selection)) for columns, selection in chosen if selection is not None
    ]
    head = ("Best law", "Next", "Difference (N²)", "s.e. (N²)", "Difference is")
    return table((*WHO, *head), rows, words=("Best law", "Next"))


def _selected(selection: Selection) -> tuple[str, ...]:
    best, following = (
        f"{law_words(law.law)} ({significant(law.rmse_n, 3)} N)" for law in selection.laws[:2]
    )
    verdict = "significant" if selection.distinguishable else "not significant"
    return (
        best,
        following,
        significant(selection.difference_n2, 3),
        significant(selection.difference_se_n2, 2),
        verdict,
    )


def selection_words(results: Results) -> str:
    """Return which law predicts best in the curves, and over all of them together."""
    of_curves = [curve.selection for curve in results.curves if curve.selection is not None]
    parts = [_best_of(of_curves)] if of_curves else []
    for joint in results.joint_fits:
        if joint.selection is not None:
            first, second = joint.selection.laws[:2]
            sizes = [f"{law_words(law.law)} ({significant(law.rmse_n, 3)} N)"
                     for law in (first, second)]  # fmt: skip
            parts.append(
                f"Over all curves together, {sizes[0]} predicts better than {sizes[1]}."
                if joint.selection.distinguishable
                else f"Over all curves together, {listed(sizes)} are not distinguishable."
            )
            if of_curves:
                laws = listed([law_words(fit.law) for fit in joint.fits])
                verb = "is" if len(joint.fits) == 1 else "are"
                parts.append(f"{laws}, fitted to all curves at once, {verb} compared only here.")
    return " ".join(parts)


def _best_of(selections: Sequence[Selection]) -> str:
    best = Counter(selection.laws[0].law for selection in selections)
    every = len(selections)
    if len(best) > 1:
        counts = listed([f"{law_words(law)} in {n}" for law, n in best.most_common()])
        words = f"No law predicts best in all {every} curves: {counts}."
    else:
        first, second = (
            span([selection.laws[place].rmse_n for selection in selections]) for place in (0, 1)
        )
        where = f"all {every} curves" if every > 1 else "the only curve"
        words = (
            f"{law_words(*best)} predicts best in {where}: RMS error {first} N, that of the next "
            f"law {second} N."
        )
    sure = sum(selection.distinguishable for selection in selections)
    if sure == every:
        return f"{words} This is significant{' in each of them' if every > 1 else ''}."
    speeds = max(selection.speeds for selection in selections)
    if sure:
        return f"{words} This is significant in {sure} of them."
    where = "significant in no single curve" if every > 1 else "not significant"
    return f"{words} This is {where}: with {speeds} held-out speeds, one large error can decide."


def law_words(law: str) -> str:
    """Return a friction law's title; a law that is not in the table keeps its name."""
    return FRICTION_LAWS[law].title if law in FRICTION_LAWS else law.replace("_", " ")


def in_words(text: str) -> str:
    """Replace the names of laws' parameters in a sentence by their titles and symbols."""
    return _replaced(text, {name: parameter.label for name, parameter in PARAMETERS.items()})


def _with_symbols(text: str) -> str:
    """Replace the names of laws' parameters in a sentence by their symbols."""
    return _replaced(text, {name: _symbol(name) for name in PARAMETERS})


def _replaced(text: str, words: Mapping[str, str]) -> str:
    for name, word in words.items():
        if "_" in name and word:
            text = re.sub(rf"\b{name}\b", word, text)
    return text


def label_and_unit(name: str, unit: str) -> tuple[str, str]:
    """Return a parameter's label and its unit on pages; a name not in the table keeps ``unit``."""
    known = PARAMETERS.get(name)
    return (name, unit) if known is None else (known.label, known.shown)


def _parameter_head(name: str, unit: str) -> str:
    label, shown = label_and_unit(name, unit)
    return f"{label} ({shown})"


def parameter_cell(name: str, parameter: FitParameter | None) -> Cell:
    """Return a parameter with its 95 % interval, flagged where a bound or the fit decides it."""
    if parameter is None:
        return Cell(NONE)
    _, shown = label_and_unit(name, "1")
    value = from_si(parameter.value, shown)
    text, flag = significant(value, 3), "not determined"
    if parameter.ci95 is not None and all(map(math.isfinite, parameter.ci95)):
        low, high = (from_si(end, shown) for end in parameter.ci95)
        more = int(_is_hidden(value, low, high))
        text, flag = with_ends(value, low, high, more), _linearised(parameter, shown)
    return Cell(text, flag if parameter.at_bound is None else f"at {parameter.at_bound} bound")


def _is_hidden(value: float, low: float, high: float) -> bool:
    """Return whether two digits of the half-width hide if it exceeds the value, which decides."""
    half = (high - low) / 2
    if not half > 0:
        return False
    unit = 10.0 ** (math.floor(math.log10(half)) - 1)
    shown, shown_low, shown_high = (unit * round(each / unit) for each in (value, low, high))
    return (half > abs(value)) != (shown_high - shown_low > 2 * abs(shown))


def _linearised(parameter: FitParameter, unit: str) -> str:
    """Return the linearised interval where it alone exceeds the value; empty elsewhere."""
    low, high = parameter.ci95 or (math.nan, math.nan)
    ends = parameter.intervals.get("linearised")
    if not parameter.wide or ends is None or (high - low) / 2 > abs(parameter.value):
        return ""
    half = (ends[1] - ends[0]) / 2
    return f"linearised ±{half_width(from_si(half, unit))}" if half > abs(parameter.value) else ""


def _residual(fit: Fit) -> str:
    """Write the RMS residual; as many parameters as points leave none but rounding errors."""
    return NONE if fit.rmse_n < 1e-6 else significant(fit.rmse_n, 3)


def _verdict_cell(fit: Fit) -> Cell:
    words = verdict_words(fit)
    return Cell(words) if fit.verdict == "determined" else Cell("", words)

"""An identification in words and numbers: tables for terminal and page, and the JSON file."""

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import asdict, replace
from typing import Any

from hbench.records import (
    DIRECTION_WORDS,
    DIRECTIONS,
    Fit,
    FitParameter,
    Identification,
    IdentifiedLaw,
    LackOfFit,
    ModelErrors,
    WordTable,
)
from hbench.records.friction_laws import parameter_named
from hbench.records.identification import PARTS
from hbench.report.campaign.fit_tables import law_words
from hbench.report.identification.misfit_words import misfit_table
from hbench.report.identification.ranking import (
    AT_REST,
    AT_SPEED,
    IN_MOTION,
    error_n,
    ranked_laws,
    rms_n,
)
from hbench.report.json_documents.values import json_text, json_value
from hbench.report.render.numbers import (
    NONE,
    force,
    number,
    significant,
    with_ends,
)
from hbench.sentences import uncapital
from hbench.units import from_si

SCHEMA = "hbench.identification/1"
_ERRORS_HEAD = (
    *("Law", "Part", "Friction (N)", "Velocity (mm/s)", "P_Tp (bar)", "P_Tr (bar)", "Samples"),
)
_PARAMETERS_HEAD = ("Law", "Parameter", "Value with 95 % interval", "Unit", "Remark")
_RAMPS_HEAD = (
    *("Direction", "Load", "Ramp (m/s²)", "Steady law, steady runs (N)", "Steady law, ramp (N)"),
    *("Ramp law, steady runs (N)", "Ramp law, ramp (N)"),
)
_HELD_OUT_HEAD = ("Law", "Friction (N)", "Runs left out of the fit")
ERRORS = "RMS errors on the verification runs"
HELD_OUT = "RMS errors along the motion of runs left out of the fits"
PARAMETERS = "Identified parameters"
SUMMARY = "Laws by their error in motion"
RAMPS = "Steady runs and ramps from breakaway on: RMS error of Tustin fits"
_ONE_ERROR = ("RMS error of friction (N)",)
_ERRORS = ("RMS error in motion (N)", "At constant speed (N)", "At rest (N)")
_DETERMINED = ("Not determined", "Hardly determined", "Plant file")
_FLOOR = "Trials' scatter"
_SURNAMES = ("Coulomb", "Stribeck")


def identification_json(identification: Identification) -> str:
    """Return ``identification.json``: all but the curves. A number that does not exist is null."""
    document = {
        "schema": SCHEMA,
        "provenance": asdict(identification.provenance),
        "laws": [_law(law) for law in identification.laws],
        "verification": {
            "runs": identification.verification_runs,
            "trial_scatter": _errors(identification.scatter),
            "not_verified": identification.not_verified or None,
        },
        "steady_and_ramp": [asdict(ramp) for ramp in identification.ramps],
        "no_ramps": identification.no_ramps or None,
        "left_out": identification.left_out,
        "notes": identification.notes,
    }
    return json_text(json_value(document))


def identification_tables(identification: Identification) -> tuple[WordTable, ...]:
    """Return the tables that have rows: errors on runs, misfit, parameters, ramps."""
    every = (
        _summary(identification),
        WordTable(
            ERRORS,
            _ERRORS_HEAD,
            tuple(_error_rows(identification)),
        ),
        WordTable(
            HELD_OUT,
            _HELD_OUT_HEAD,
            tuple(
                (law.law, number(law.held_out_n, 1), ", ".join(law.held_out_runs))
                for law in identification.laws
                if law.held_out_n is not None
            ),
        ),
        misfit_table(identification),
        WordTable(PARAMETERS, _PARAMETERS_HEAD, tuple(_parameter_rows(identification))),
        WordTable(
            RAMPS,
            _RAMPS_HEAD,
            tuple(_ramps(identification)),
        ),
    )
    return tuple(table for table in every if table.rows)


def with_law_names(table: WordTable) -> WordTable:
    """Return a table with the laws' names in place of their keys."""
    rows = tuple((law_words(first), *rest) for first, *rest in table.rows)
    return replace(table, rows=rows)


def reasons(identification: Identification) -> tuple[str, ...]:
    """Return the reasons for missing results and the messages of fits, a sentence each."""
    sentences = [identification.not_verified] if identification.not_verified else []
    for law in identification.laws:
        if law.fit is None:
            sentences.append(f"{law_words(law.law)} is not identified: {law.reason}")
        elif law.fit.message:
            sentences.append(f"{law.law}: {_with_titles(law.fit)}")
        if law.not_verified:
            sentences.append(f"{law.law}: {law.not_verified}")
    if identification.no_ramps:
        sentences.append(f"steady fits and ramps are not compared: {identification.no_ramps}")
    return tuple(sentences)


def _law(law: IdentifiedLaw) -> dict[str, Any]:
    fit = law.fit
    return {
        "law": law.law,
        "identified": fit is not None,
        "reason": law.reason or None,
        "parameters": {name: asdict(p) for name, p in fit.parameters.items()} if fit else {},
        "rmse_n": fit.rmse_n if fit else None,
        "converged": fit.converged if fit else None,
        "message": fit.message if fit else None,
        "runs": law.runs,
        "friction": law.section or None,
        "errors": _errors(law.errors),
        "steady_parts": asdict(law.steady) if law.steady else None,
        "not_verified": law.not_verified or None,
        "held_out_n": law.held_out_n,
        "held_out_runs": law.held_out_runs,
        "misfit": _misfit(law.misfit),
        "misfit_in_motion": _misfit(law.misfit_in_motion),
    }


def _misfit(fit: LackOfFit | None) -> dict[str, Any] | None:
    return None if fit is None else {**asdict(fit), "share": fit.share, "describes": fit.describes}


def _errors(errors: Mapping[str, ModelErrors]) -> dict[str, Any] | None:
    return {part: asdict(errors[part]) for part in PARTS} if errors else None


def _summary(identification: Identification) -> WordTable:
    """Return a row for each law, the smallest error first; none where no law has an error."""
    verified = any(law.errors for law in identification.laws)
    rows = []
    for law in ranked_laws(identification):
        rest = (_steady_words(law), _rms_words(law.errors, (AT_REST,))) if verified else ()
        if law.fit is None:
            cells = (NONE, *(NONE for _ in rest), "all: not identified", NONE, NONE)
        else:
            names = ", ".join(map(_symbol, law.fit.undetermined))
            hardly = ", ".join(map(_symbol, law.fit.hardly_determined))
            error = number(error_n(law), 1)
            cells = (error, *rest, names or "none", hardly or "none", f"{law.law}.yaml")
        rows.append((law.law, *cells))
    known = verified or any(law.held_out_n for law in identification.laws)
    head = ("Law", *(_ERRORS if verified else _ONE_ERROR), *_DETERMINED)
    return WordTable(SUMMARY, head, tuple(rows) if known else ())


def _steady_words(law: IdentifiedLaw) -> str:
    """Write the error at constant speeds; in brackets without oscillating parts, if any."""
    every = _rms_words(law.errors, (AT_SPEED,))
    if law.steady is None or law.steady.oscillating is None:
        return every
    return f"{every} ({'none' if law.steady.smooth is None else _smooth(law.steady.smooth)})"


def _smooth(errors: ModelErrors) -> str:
    return number(errors.friction_n, 1)


def scatter_words(identification: Identification) -> str:
    """Write how the trials of the verification runs scatter about their mean."""
    parts = ((IN_MOTION, "in motion"), ((AT_SPEED,), "at constant speed"), ((AT_REST,), "at rest"))
    return ", ".join(f"{scatter_n(identification, part)} N {where}" for part, where in parts)


def scatter_n(identification: Identification, parts: Iterable[str]) -> str:
    """Write the trials' scatter of friction [N] in parts of the verification runs."""
    return _rms_words(identification.scatter, parts)


def _rms_words(errors: Mapping[str, ModelErrors], parts: Iterable[str]) -> str:
    error = rms_n(errors[part] for part in parts if part in errors)
    return number(error, 1)


def error_range(errors_n: Collection[float]) -> str:
    """Write the smallest and the largest error with the decimals of the tables."""
    return "–".join(dict.fromkeys(number(end, 1) for end in (min(errors_n), max(errors_n))))


def hardly_determined_words(fit: Fit) -> list[str]:
    """Return the parameters that the runs hardly determine."""
    return [_title(name) for name in fit.hardly_determined]


def undetermined_words(fit: Fit) -> list[str]:
    """Return the parameters that the runs do not determine, with the bound at which one is."""
    return [
        f"{_title(name)} (at its {bound} bound)" if bound else _title(name)
        for name in fit.undetermined
        for bound in [fit.parameters[name].at_bound]
    ]


def _symbol(name: str) -> str:
    """Return a parameter's symbol with its direction."""
    known = parameter_named(name)
    if known is None:
        return name
    symbol = known.symbol
    if known.of_several:
        symbol = symbol.replace("_i", f"_{name.split('_')[1]}")
    side = name.partition("_")[0]
    return f"{symbol} {side}ing" if side in DIRECTIONS else symbol


def _error_rows(identification: Identification) -> list[tuple[str, ...]]:
    rows = []
    for law in identification.laws:
        for part in PARTS if law.errors else ():
            rows.append(_error_row(law.law, part, law.errors[part]))
            if part == "steady" and law.steady and law.steady.oscillating:
                split = (("smooth", law.steady.smooth), ("oscillating", law.steady.oscillating))
                rows += [_error_row(law.law, f"steady, {kind}", e) for kind, e in split if e]
    if rows:
        rows += [
            _error_row(_FLOOR, part, identification.scatter[part])
            for part in PARTS
            if identification.scatter
        ]
    return rows


def _error_row(name: str, part: str, errors: ModelErrors) -> tuple[str, ...]:
    return (
        name,
        part,
        number(errors.friction_n, 1),
        number(1e3 * errors.v_m_s, 2),
        number(errors.p_tp_pa / 1e5, 3),
        number(errors.p_tr_pa / 1e5, 3),
        str(errors.samples),
    )


def _parameter_rows(identification: Identification) -> list[tuple[str, ...]]:
    return [
        _parameter_row(law.law, name, parameter)
        for law in identification.laws
        if law.fit is not None
        for name, parameter in law.fit.parameters.items()
    ]


def _parameter_row(law: str, name: str, parameter: FitParameter) -> tuple[str, ...]:
    """Write a parameter with its title and symbol, in the unit of pages and bench files."""
    words, unit = parameter_words(name, parameter.unit)
    value = from_si(parameter.value, unit)
    if parameter.ci95 is None:
        text = significant(value, 3)
    else:
        low, high = (from_si(end, unit) for end in parameter.ci95)
        text = with_ends(value, low, high)
    remark = "" if parameter.determination == "determined" else f"{parameter.determination}"
    remark = f"at {parameter.at_bound} bound" if parameter.at_bound else remark
    return (law, words, text, unit, remark)


def parameter_words(name: str, unit: str) -> tuple[str, str]:
    """Return a parameter's title with symbol and direction, and its unit on pages.

    ``name`` may be one of several (``theta_2_n``) or of a direction (``extend_low_force_n``); one
    that the table of laws does not have is returned as it is.
    """
    known = parameter_named(name)
    if known is None:
        return name, unit
    words = known.label
    if known.of_several:
        number = name.split("_")[1]
        words = words.replace("element i", f"element {number}").replace("_i", f"_{number}")
    side = name.partition("_")[0]
    return (f"{words}, {side}ing" if side in DIRECTIONS else words), known.shown or unit


def _with_titles(fit: Fit) -> str:
    """Return a fit's message with the parameters' titles in place of their keys."""
    return re.sub(r"\b[a-z]\w*_\w+\b", lambda key: _title(key[0]), fit.message)


def _title(name: str) -> str:
    """Return a parameter's title within a sentence."""
    title, _ = parameter_words(name, "")
    return title if title.startswith(_SURNAMES) else uncapital(title)


def _ramps(identification: Identification) -> list[tuple[str, ...]]:
    slowest = min((ramp.a_ref_m_s2 for ramp in identification.ramps), default=1.0)
    decimals = len(significant(slowest, 3).partition(".")[2])
    return [
        (
            DIRECTION_WORDS[ramp.direction],
            force(ramp.f_load_n),
            number(ramp.a_ref_m_s2, decimals),
            number(ramp.steady_on_steady_n),
            number(ramp.steady_on_ramp_n),
            number(ramp.ramp_on_steady_n),
            number(ramp.ramp_on_ramp_n),
        )
        for ramp in identification.ramps
    ]

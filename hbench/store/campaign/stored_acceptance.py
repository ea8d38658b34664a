"""The decisions that ``hbench accept`` wrote into a campaign folder."""

import math
import os
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any, Literal, get_args

from hbench.records.conformity.acceptance import (
    Conformity,
    ConformityCheck,
    LimitQuantity,
    Measurement,
    Requirement,
    Rule,
)
from hbench.records.motions import Leak
from hbench.records.runs import DIRECTIONS
from hbench.store.campaign.stored_diagnosis import read_document
from hbench.units import parse_unit
from hbench.untrusted_text import printable

FILE_NAME = "acceptance.json"
SCHEMA = "hbench.acceptance/1"
_LARGEST = 4_000_000  # bytes; the decisions of some hundred series take a tenth of it
_MOST_CHECKS = 500
_LONGEST = 500  # characters of a reason
_CHOICES: dict[str, tuple[str, ...]] = {
    "quantity": get_args(LimitQuantity),
    "direction": DIRECTIONS,
    "leak": get_args(Leak),
}
_TEXTS = ("unit", "name", "label", *_CHOICES)
_FLAGS = ("without_instruments",)


def stored_decision(folder: Path) -> Conformity | Literal[""]:
    """Return the decision of the campaign's last acceptance; empty if there is none to read.

    A link out of the campaign is not followed.
    """
    decision = _content(folder).get("decision")
    return next((known for known in get_args(Conformity) if known == decision), "")


def stored_checks(folder: Path) -> tuple[ConformityCheck, ...]:
    """Return the decisions of the campaign's last acceptance, as they were written.

    One without a measured value is NOT TESTED. One with an entry that hbench does not write is left
    out.
    """
    checks = _content(folder).get("checks")
    return tuple(_checks(checks[:_MOST_CHECKS])) if isinstance(checks, list) else ()


def is_of_poor_data(folder: Path) -> bool:
    """Return whether the data of the campaign's last acceptance were rated poor."""
    return _content(folder).get("data") == "poor"


def stored_rule(folder: Path) -> tuple[Rule | None, float | None, str]:
    """Return the decision rule, the largest U of shared risk as a share, and the file of limits.

    What the last acceptance does not state is None, or empty.
    """
    content = _content(folder)
    rule, largest, limits = (content.get(k) for k in ("rule", "largest_uncertainty", "limits"))
    return (
        rule if rule in get_args(Rule) else None,
        _float(largest),
        printable(limits[:_LONGEST]) if isinstance(limits, str) else "",
    )


def _content(folder: Path) -> dict[str, Any]:
    path = folder / "results" / FILE_NAME
    if not os.path.isfile(path) or not path.resolve().is_relative_to(folder.resolve()):
        return {}
    content = read_document(path, SCHEMA, _LARGEST)
    return content if isinstance(content, dict) else {}


def _checks(rows: list[Any]) -> Iterator[ConformityCheck]:
    for row in rows:
        if not isinstance(row, dict):
            continue
        requirement = _record(Requirement, row.get("requirement"))
        measurement = _record(Measurement, row.get("measurement"))
        reason = row.get("reason")
        words = printable(reason[:_LONGEST]) if isinstance(reason, str) else ""
        if requirement and measurement and row.get("decision") in get_args(Conformity):
            decision: Conformity = row["decision"]
            probability = _float(row.get("probability"))
            if probability is not None and not 0 <= probability <= 1:
                probability = None
            yield ConformityCheck(
                Requirement(**requirement),
                Measurement(**measurement),
                probability,
                decision,
                words if decision == "NOT TESTED" else "",
            )
        elif requirement and row.get("decision") == "NOT TESTED" and isinstance(reason, str):
            if row.get("measurement") is None:
                yield ConformityCheck(Requirement(**requirement), None, None, "NOT TESTED", words)


def _record(kind: type, content: Any) -> dict[str, Any]:
    """Return the fields of a record; empty if one of them has no possible value."""
    if not isinstance(content, dict):
        return {}
    found = {}
    for field in fields(kind):
        value = content.get(field.name)
        if field.name == "runs":
            continue
        if field.name in _TEXTS:
            known = _CHOICES.get(field.name)
            if value is not None and not isinstance(value, str):
                return {}
            if (known and value is not None and value not in known) or (
                field.name == "unit" and not _is_unit(value)
            ):
                return {}
            value = None if value is None else printable(value)
        elif field.name in _FLAGS:
            if not isinstance(value, bool | None):
                return {}
        elif value is not None and not _is_number(value):
            return {}
        if value is not None:
            found[field.name] = value
        elif field.name in ("low", "high", "u95"):
            found[field.name] = None
    needed = {"value"} if kind is Measurement else {"quantity", "unit"}
    return found if needed <= set(found) else {}


def _is_unit(text: str | None) -> bool:
    try:
        parse_unit(text or "")
    except ValueError:
        return False
    return True


def _float(value: Any) -> float | None:
    return float(value) if _is_number(value) else None


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)

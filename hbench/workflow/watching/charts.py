"""Control charts of a test station: measured values of the last cylinders, with their limits."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from hbench.analysis.conformity.series import Series, checks_by_series
from hbench.analysis.fleet.control_chart import centre_and_sigma
from hbench.analysis.fleet.run_rules import run_rules
from hbench.records import FEWEST_CAMPAIGNS
from hbench.records.conformity.acceptance import ConformityCheck
from hbench.report.conformity.decision_section import nearest_words
from hbench.report.conformity.text import (
    QUANTITIES,
    check_words,
    limit_words,
    measured_words,
)
from hbench.report.render.numbers import unit_kept
from hbench.units import from_si

_MOST = 4  # charts, and values that did not pass
_ORDER = ("FAIL", "MARGINAL", "NOT TESTED", "PASS")


def station_charts(
    names: Sequence[str], checks: Sequence[Sequence[ConformityCheck]]
) -> list[dict[str, Any]]:
    """Return charts of quantities that the last decided cylinder has limits of: at most four.

    Those that failed come first, then marginal ones. ``names`` and ``checks`` are those of the
    cylinders, in the order of their tests. A chart has the values in the unit of the limits with
    their expanded uncertainties, the last one in words, and from ten cylinders on the control
    limits, mean ± 3 sigma of the moving ranges, with the rules that signal at each value, and
    whether one does at the last.
    """
    by_series = [checks_by_series(each) for each in checks]
    newest = next(filter(None, reversed(by_series)), dict[Series, ConformityCheck]())
    shown = sorted(newest, key=lambda series: _ORDER.index(newest[series].decision))[:_MOST]
    return [_chart(series, names, by_series) for series in shown]


def limits_checked(checks: Sequence[ConformityCheck]) -> list[str]:
    """Count the limits that were kept; write the first of the others, and count the rest.

    If all were kept, the value nearest to its limit follows.
    """
    others = sorted(
        (check for check in checks if check.decision != "PASS"),
        key=lambda check: _ORDER.index(check.decision),
    )
    words = [
        unit_kept(f"{c.decision}: {check_words(c.requirement, c.measurement)}: {_measured(c)}")
        for c in others
    ]
    kept = f"Limits met: {len(checks) - len(words)} of {len(checks)}."
    more = [f"{len(words) - _MOST} more; see hbench accept"] if len(words) > _MOST else []
    nearest = "" if others else unit_kept(nearest_words("PASS", checks))
    return [*([kept] if checks else []), *words[:_MOST], *more, *filter(None, [nearest])]


def _measured(check: ConformityCheck) -> str:
    limit = f"limit {limit_words(check.requirement)}"
    if check.measurement is None:
        return f"{check.reason}; {limit}" if check.reason else limit
    return f"{measured_words(check)} (95 %), {limit}"


def _chart(
    series: Series, names: Sequence[str], checks: Sequence[dict[Series, ConformityCheck]]
) -> dict[str, Any]:
    found = [
        (name, each[series]) for name, each in zip(names, checks, strict=True) if series in each
    ]
    last = found[-1][1]
    unit, limits = last.requirement.unit, last.requirement
    measured = [check.measurement for _, check in found if check.measurement]
    values = np.array([from_si(each.value, unit) for each in measured])
    halves = [None if each.u95 is None else from_si(each.u95, unit) for each in measured]
    chart: dict[str, Any] = {
        "title": unit_kept(check_words(last.requirement, last.measurement)),
        "quantity": QUANTITIES[limits.quantity],
        "unit": unit,
        "names": [name for name, _ in found],
        "values": values.tolist(),
        "u95": halves,
        "last": unit_kept(f"{found[-1][0]}: {_measured(last)}"),
        "low": None if limits.low is None else from_si(limits.low, unit),
        "high": None if limits.high is None else from_si(limits.high, unit),
        "control": None,
        "signals": [""] * len(values),
        "fewest": FEWEST_CAMPAIGNS,
        "last_unusual": False,
    }
    if len(values) >= FEWEST_CAMPAIGNS:
        centre, sigma = centre_and_sigma(values)
        chart["control"] = [centre - 3 * sigma, centre, centre + 3 * sigma]
        if sigma > 0:
            rules = run_rules((values - centre) / sigma)
            chart["signals"] = [
                "; ".join(rule for rule, at in rules.items() if at[i]) for i in range(len(values))
            ]
            chart["last_unusual"] = last.measurement is not None and bool(chart["signals"][-1])
    return chart

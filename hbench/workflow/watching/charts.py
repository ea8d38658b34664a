"""Control charts of a test station: measured values of the last cylinders, with their limits."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from hbench.analysis.comparison.control_chart import FEWEST, centre_and_sigma
from hbench.analysis.comparison.run_rules import run_rules
from hbench.records.conformity.acceptance import ConformityCheck
from hbench.report.conformity.text import (
    limit_words,
    measured_words,
    requirement_words,
    series_words,
)
from hbench.units import from_si

_MOST = 4  # charts, and values that did not pass
Series = tuple[tuple, tuple, int]  # requirement, label and load, number of its kind


def station_charts(
    names: Sequence[str], checks: Sequence[Sequence[ConformityCheck]]
) -> list[dict[str, Any]]:
    """Return charts of quantities that the last decided cylinder has limits of: at most four.

    Those that did not pass come first.
    ``names`` and ``checks`` are those of the cylinders, in the order of their tests. A chart has
    the values in the unit of the limits, the last one in words with its uncertainty, and from ten
    cylinders on the control limits, mean ± 3 sigma of the moving ranges, with the rules that
    signal at each value.
    """
    newest = next((each for each in reversed(checks) if each), ())
    by_series = [_by_series(each) for each in checks]
    decisions = _by_series(newest)
    shown = sorted(decisions, key=lambda series: decisions[series].decision == "PASS")[:_MOST]
    return [_chart(series, names, by_series) for series in shown]


def not_passed(checks: Sequence[ConformityCheck]) -> list[str]:
    """Write the first measured values that did not pass, with their limits; count the others."""
    words = [
        f"{check.decision}: {_title(check)}: {_measured(check)}"
        for check in sorted(checks, key=lambda check: check.decision != "FAIL")
        if check.decision != "PASS"
    ]
    more = [f"{len(words) - _MOST} more; see hbench accept"] if len(words) > _MOST else []
    return words[:_MOST] + more


def _title(check: ConformityCheck) -> str:
    return ", ".join(filter(None, (requirement_words(check), series_words(check))))


def _measured(check: ConformityCheck) -> str:
    return f"{measured_words(check)} (95 %), limit {limit_words(check.requirement)}"


def _by_series(checks: Sequence[ConformityCheck]) -> dict[Series, ConformityCheck]:
    """Return the checks of a cylinder by what they are of.

    Measured speeds, which differ a little from cylinder to cylinder, are no part of that: several
    speeds of a series are counted.
    """
    found: dict[Series, ConformityCheck] = {}
    for check in checks:
        what, series = check.requirement, check.measurement
        assert series is not None
        load = (series.label, series.direction, series.f_load_n, series.p_lr_ref_pa)
        named = (what.quantity, what.unit, what.name, what.v_m_s, what.dwell_s, what.leak)
        count = sum(key[:2] == (named, load) for key in found)
        found[named, load, count] = check
    return found


def _chart(
    series: Series, names: Sequence[str], checks: Sequence[dict[Series, ConformityCheck]]
) -> dict[str, Any]:
    found = [
        (name, each[series]) for name, each in zip(names, checks, strict=True) if series in each
    ]
    last = found[-1][1]
    unit, limits = last.requirement.unit, last.requirement
    values = np.array(
        [from_si(check.measurement.value, unit) for _, check in found if check.measurement]
    )
    chart: dict[str, Any] = {
        "title": _title(last),
        "unit": unit,
        "names": [name for name, _ in found],
        "values": values.tolist(),
        "last": f"{found[-1][0]}: {_measured(last)}",
        "low": None if limits.low is None else from_si(limits.low, unit),
        "high": None if limits.high is None else from_si(limits.high, unit),
        "control": None,
        "signals": [""] * len(values),
        "fewest": FEWEST,
    }
    if len(values) >= FEWEST:
        centre, sigma = centre_and_sigma(values)
        chart["control"] = [centre - 3 * sigma, centre, centre + 3 * sigma]
        if sigma > 0:
            rules = run_rules((values - centre) / sigma)
            chart["signals"] = [
                "; ".join(rule for rule, at in rules.items() if at[i]) for i in range(len(values))
            ]
    return chart

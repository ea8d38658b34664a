"""Control charts of a test station: measured values of the last cylinders, with their limits."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from hbench.analysis.comparison.control_chart import FEWEST, centre_and_sigma
from hbench.analysis.comparison.run_rules import run_rules
from hbench.records.conformity.acceptance import ConformityCheck
from hbench.report.conformity.text import requirement_words, series_words
from hbench.units import from_si

_MOST = 4  # charts


def station_charts(
    names: Sequence[str], checks: Sequence[Sequence[ConformityCheck]]
) -> list[dict[str, Any]]:
    """Return a chart for each of the first quantities that the last decided cylinder has limits of.

    ``names`` and ``checks`` are those of the cylinders, in the order of their tests. A chart has
    the values in the unit of the limits, and from ten cylinders on the control limits, mean ± 3
    sigma of the moving ranges, with the rules that signal at each value.
    """
    newest = next((each for each in reversed(checks) if each), ())
    titles = list(dict.fromkeys(map(_title, newest)))[:_MOST]
    return [_chart(title, names, checks) for title in titles]


def _title(check: ConformityCheck) -> str:
    return " ".join(filter(None, (requirement_words(check), series_words(check))))


def _chart(
    title: str, names: Sequence[str], checks: Sequence[Sequence[ConformityCheck]]
) -> dict[str, Any]:
    found = [
        (name, check)
        for name, each in zip(names, checks, strict=True)
        for check in each
        if _title(check) == title
    ]
    unit = found[-1][1].requirement.unit
    limits = found[-1][1].requirement
    values = np.array(
        [from_si(check.measurement.value, unit) for _, check in found if check.measurement]
    )
    chart: dict[str, Any] = {
        "title": title,
        "unit": unit,
        "names": [name for name, _ in found],
        "values": values.tolist(),
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

"""From a campaign to its results and its report."""

from dataclasses import replace
from pathlib import Path

from hbench.analysis.average import curves
from hbench.analysis.bands import bands
from hbench.analysis.budget import with_instruments
from hbench.analysis.calibrate import calibrate
from hbench.analysis.efficiency import efficiency
from hbench.analysis.fit import fits, left_out
from hbench.analysis.screen import screen
from hbench.errors import DataError
from hbench.records import Results
from hbench.report.figures import draw_all
from hbench.report.page import page_html
from hbench.report.tables import TABLES
from hbench.store.campaign import Campaign, load_campaign, write_results


def analyze(folder: Path) -> Results:
    """Screen, average and fit a campaign; write its tables to ``results/``."""
    results = derive(load_campaign(folder))
    write_results(folder, _tables(results))
    return results


def report(folder: Path) -> Results:
    """Analyze a campaign and write tables, figures and the page to ``results/``."""
    results = derive(load_campaign(folder))
    drawings = draw_all(results)
    figures = {f"figures/{d.name}.svg": d.svg for d in drawings}
    figures |= {f"figures/{d.name}.png": d.png for d in drawings}
    page = {"report.html": page_html(results, drawings).encode()}
    write_results(folder, _tables(results) | figures | page)
    return results


def derive(campaign: Campaign) -> Results:
    """Screen, average and fit a campaign; nothing is written. Raises ``DataError``."""
    bench, rules = campaign.bench(), campaign.screening()
    if campaign.imported:
        runs = campaign.runs()
    else:
        runs = (calibrate(raw, bench) for raw in campaign.raw_runs())
    screened = tuple(screen(run, rules) for run in runs)
    if not screened:
        raise DataError(f"{campaign.folder}: holds no runs", "Go on with `hbench run --resume`.")
    instruments = None if bench is None else bench.instruments
    found = tuple(
        with_instruments(replace(curve, fits=fits(curve)), instruments)
        for curve in curves(screened)
    )
    return Results(
        provenance=campaign.provenance(),
        runs=screened,
        curves=found,
        efficiency=tuple(efficiency(curve, instruments) for curve in found),
        bands=bands(found),
        notes=(*campaign.warnings, *left_out(found)),
    )


def _tables(results: Results) -> dict[str, bytes]:
    return {name: table(results).encode() for name, table in TABLES.items()}

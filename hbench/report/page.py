"""The report page: one HTML file that needs nothing else."""

import base64
import json
from collections import Counter
from collections.abc import Iterable
from typing import Any

from hbench.records import Results
from hbench.report import page_motions, page_tables
from hbench.report.document import rendered
from hbench.report.draw_friction import has_curves, over_velocity
from hbench.report.draw_rejected import has_rejected
from hbench.report.figures import Drawing
from hbench.report.fit_tables import fit_tables, selection_table
from hbench.report.text import number, span
from hbench.units import from_si

_SECTIONS = "friction ramps hysteresis steps leakage efficiency rejected".split()
LONG_LIST = 12  # a longer list of rejected runs or of notes starts folded
_FEW = 3  # and a longer one of a fit's remarks

_BANNERS = {
    "simulated": "Simulated. The virtual rig made these numbers; no cylinder was measured.",
    "imported": "Imported. Another bench logged these runs; hbench screened and analyzed them.",
    "real": "Measured on a bench that hbench ran.",
}


def page_html(results: Results, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside. Every text of the campaign is escaped."""
    sections: dict[str, list[dict[str, str]]] = {name: [] for name in _SECTIONS}
    for count, drawing in enumerate(drawings, start=1):
        sections[drawing.section].append(
            {
                "number": str(count),
                "title": drawing.title,
                "caption": drawing.caption,
                "data": base64.b64encode(drawing.svg).decode("ascii"),
            }
        )
    return rendered(
        "template.html.j2",
        provenance=results.provenance,
        banner=_BANNERS[results.provenance.source],
        tiles=_tiles(results),
        figures=sections,
        fits=fit_tables(results),
        selection=selection_table(results),
        points=page_tables.point_table(results),
        efficiency=page_tables.efficiency_table(results),
        budget=page_tables.budget_table(results),
        pressure=page_tables.pressure_table(results),
        steady=any(curve.kind == "steady" for curve in results.curves),
        comparisons=page_motions.comparison_table(results),
        loops=page_motions.loop_table(results),
        levels=page_motions.level_table(results),
        leaks=page_motions.leak_table(results),
        surfaces=results.motions.surfaces,
        rejected=page_tables.rejected_table(results),
        long_list=LONG_LIST,
        few=_FEW,
        any_rejected=has_rejected(results),
        remarks=page_tables.remark_table(results),
        facts=_facts(results),
        notes=results.notes,
    )


def _tiles(results: Results) -> list[tuple[str, str, str]]:
    """Return (value, unit or noun, more) of each tile."""
    made = len(results.runs)
    accepted = sum(run.accepted for run in results.runs)
    tiles = [
        (str(made), "runs", "made"),
        (str(accepted), "accepted", _share(accepted, made)),
        (str(made - accepted), "rejected", "reasons below" if accepted < made else ""),
    ]
    curves = [curve for curve in results.curves if curve.kind == "steady"]
    points = [point for curve in curves for point in curve.points]
    kinds = Counter(run.run.plan.kind for run in results.runs if run.run.plan.kind != "steady")
    if kinds:
        words = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
        tiles.append((str(kinds.total()), "not steady", words))
    if not points:
        return tiles
    tiles.append((span([1e3 * abs(point.v_m_s) for point in points]), "mm/s", "speeds"))
    loads = {abs(curve.f_load_n) for curve in curves if curve.f_load_n is not None}
    directions = {curve.direction for curve in curves}
    both = "both directions" if len(directions) == 2 else "one direction"
    if loads:
        count = "1 load" if len(loads) == 1 else f"{len(loads)} loads"
        tiles.append((span(loads), "N", f"{count}, {both}"))
    if has_curves(results):
        for pick, words in ((min, "lowest"), (max, "highest")):
            ends = [pick(c.points, key=lambda p: abs(p.v_m_s)) for c in over_velocity(results)]
            friction = span([abs(point.friction_n) for point in ends])
            tiles.append((friction, "N", f"friction at the {words} speed"))
    else:
        pressures = [from_si(point.p_tp_pa, "bar") for point in points]
        tiles.append((span(pressures), "bar", "chamber pressure"))
        tiles.append((span([abs(point.friction_n) for point in points]), "N", "friction"))
    return tiles


def _share(part: int, whole: int) -> str:
    return f"{number(100 * part / whole)} % of the runs" if whole else ""


def _facts(results: Results) -> list[tuple[str, str]]:
    """Return what was measured by what, as names and values."""
    provenance = results.provenance
    facts = [
        ("Source", provenance.source),
        ("Bench", provenance.bench),
        ("Firmware", provenance.firmware),
        ("Started", provenance.started),
        ("Stopped", provenance.stopped),
    ]
    for specimen in dict.fromkeys(run.run.plan.specimen for run in results.runs if run.accepted):
        areas = (1e6 * specimen.area_piston_m2, 1e6 * specimen.area_rod_m2)
        words = f"A_p {number(areas[0])} mm², A_r {number(areas[1])} mm²"
        if specimen.stroke_m is not None:
            words += f", stroke {number(1e3 * specimen.stroke_m, 0)} mm"
        facts.append(("Cylinder", words))
    facts += [(name, _words(value)) for name, value in provenance.details.items()]
    facts += [(f"Version of {name}", version) for name, version in provenance.software.items()]
    return [(name, value or "not recorded") for name, value in facts]


def _words(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value, default=str, ensure_ascii=False)

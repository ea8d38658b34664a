"""Acceptance of a cylinder: a campaign against a file of limits."""

from pathlib import Path

from hbench.analysis.conformity.acceptance import conformity_checks
from hbench.config.conformity.limits import parse_limits
from hbench.config.files.loading import file_sha256, read_yaml
from hbench.records import Results
from hbench.records.conformity.acceptance import Acceptance
from hbench.report.campaign.quality.completeness import missing_words
from hbench.report.campaign.quality.verdict import grade_words
from hbench.report.conformity.acceptance_document import acceptance_json
from hbench.report.conformity.junit import junit_xml
from hbench.report.creep_words import creep_facts
from hbench.report.drift import drift_outside_u
from hbench.report.quality_words import LOAD_CELL_ZERO
from hbench.report.zero_words import zero_reserve
from hbench.store.campaign.folder import load_campaign, write_results
from hbench.workflow.results import derive


def accept(folder: Path, limits_file: Path) -> Acceptance:
    """Decide whether a campaign's cylinder conforms; write ``acceptance.json`` and ``.xml``."""
    acceptance = decided(derive(load_campaign(folder)), limits_file)
    files = {
        "acceptance.json": acceptance_json(acceptance),
        "acceptance.xml": junit_xml(acceptance),
    }
    write_results(folder, {name: text.encode() for name, text in files.items()})
    return acceptance


def decided(results: Results, limits_file: Path) -> Acceptance:
    """Return the decisions on a campaign's cylinder; nothing is written."""
    limits = parse_limits(read_yaml(limits_file), str(limits_file))
    settings = results.provenance.settings
    notes = []
    if results.quality.grade != "good":
        notes.append(grade_words(results.quality))
    if missing := missing_words(results.quality.completeness):
        notes.append(missing)
    if reserve := zero_reserve(results):
        notes.append(reserve.removesuffix("."))
    elif results.motions.load_cell_zero_unchecked:
        notes.append(LOAD_CELL_ZERO)
    notes += [f"{name}: {words.removesuffix('.')}" for name, words in creep_facts(results)]
    quantities = {limit.requirement.quantity for limit in limits.limits}
    if quantities & {"friction", "efficiency"} and (reserve := drift_outside_u(results.drift)):
        notes.append(reserve)
    checks = conformity_checks(
        results,
        [limit.requirement for limit in limits.limits],
        limits.rule,
        limits.largest_uncertainty,
    )
    return Acceptance(
        provenance=results.provenance,
        serial=str((settings.get("specimen") or {}).get("serial", "")),
        product=limits.product,
        limits=limits_file.name,
        limits_sha256=file_sha256(limits_file),
        rule=limits.rule,
        largest_uncertainty=limits.largest_uncertainty,
        checks=checks,
        data=results.quality.grade,
        notes=tuple(notes),
    )

"""Identification of friction laws from a campaign, verified in a model of its bench."""

from collections.abc import Sequence
from pathlib import Path

from hbench.analysis.identification.usable_runs import identification_use, usable_runs
from hbench.errors import DataError
from hbench.experiment.progress import Report
from hbench.records import KINDS, Identification, Run
from hbench.report.identification.figures import draw_identification
from hbench.report.identification.page import identification_page
from hbench.report.identification.plant_file import overlay_yaml
from hbench.report.identification.text import identification_json
from hbench.report.render.figures import figure_files
from hbench.sentences import listed
from hbench.store.campaign.folder import load_campaign
from hbench.store.files.atomic import write_document
from hbench.workflow.results import derive

_ADD = "Measure the schedule configs/dynamics.yaml, which `hbench init DIR` writes."
_DETERMINE = ("steady_curve", "motion")  # uses of runs that laws are fitted to
_LOAD_SIDE = "The load cylinder's friction is not identified: the model uses the bench file's."
_NO_NOISE = "The models have no scatter from stroke to stroke and no sensor noise."


def identify(folder: Path, report: Report) -> Identification:
    """Identify the test cylinder's friction laws, and verify each on the verification runs.

    Verification runs are not used for identification. Raises ``DataError``.
    """
    from hbench.analysis.curves.ramp_fits import compare_fits
    from hbench.analysis.identification.held_out import split_motions, with_held_out_errors
    from hbench.analysis.identification.identify import identify_laws  # slow import: it compiles
    from hbench.analysis.identification.lack_of_fit import with_lack_of_fit
    from hbench.analysis.identification.steady_curves import laws_along_curves
    from hbench.analysis.identification.verification import trial_scatter
    from hbench.experiment.law_verification import VerifiedLaws, verify_laws

    campaign = load_campaign(folder)
    measured_kinds = sorted({plan.kind for plan in campaign.plans})
    uses = {KINDS[kind].identification for kind in measured_kinds}
    if uses and uses.isdisjoint(_DETERMINE):
        needed = [name for name, kind in KINDS.items() if kind.identification in _DETERMINE]
        raise DataError(
            f"{folder}: no friction law can be identified from runs of the kind "
            f"{listed(measured_kinds)}; that needs {listed(needed)} runs",
            _ADD,
        )
    mass_kg = campaign.setup().test_mass_kg
    if mass_kg is None:
        raise DataError(
            f"{folder}: the moving mass of the test side is not known",
            "Add 'moving_mass' to the import map, or a bench file bench.yaml beside runs.csv, and "
            "import again.",
        )
    results = derive(campaign)
    usable, left_out = usable_runs(results.runs, mass_kg)
    steady = [curve for curve in results.curves if identification_use(curve) == "steady_curve"]
    motions = [motion for run, motion in usable if identification_use(run.plan) == "motion"]
    motions, held_out = split_motions(motions) if campaign.imported else (motions, [])
    laws = with_held_out_errors(identify_laws(steady, motions), held_out)
    laws = with_lack_of_fit(laws, steady, [*motions, *held_out])
    if not any(law.fit for law in laws):
        reasons = "; ".join(f"{law.law}: {law.reason}" for law in laws)
        raise DataError(f"{folder}: no friction law can be identified. {reasons}", _ADD)
    ramps = compare_fits(results.curves)
    measured = [run for run, _ in usable if identification_use(run.plan) == "verification"]
    has_bench = campaign.bench() is not None
    not_verified = _not_verified(measured, has_bench=has_bench)
    if not_verified:
        verified, scatter = VerifiedLaws(laws, ()), {}
    else:
        verified = verify_laws(campaign.bench_content, laws, measured, campaign.plans, report)
        scatter = trial_scatter(measured, mass_kg)
    return Identification(
        provenance=results.provenance,
        laws=verified.laws,
        ramps=ramps,
        no_ramps="" if ramps else "no ramp has the direction, load and p_lr of a steady curve",
        verification_runs=() if not_verified else tuple(run.plan.run for run in measured),
        scatter=scatter,
        not_verified=not_verified,
        followed=verified.followed,
        left_out=left_out,
        notes=(*([_LOAD_SIDE] if has_bench else []), _NO_NOISE, *campaign.warnings),
        steady=laws_along_curves(steady, laws),
    )


def write_identification(folder: Path, identification: Identification) -> None:
    """Write the page, its figures, the numbers as JSON and a plant file for each law."""
    drawings = draw_identification(identification)
    files = figure_files(drawings)
    for law in identification.laws:
        if law.fit is not None:
            files[f"{law.law}.yaml"] = overlay_yaml(identification, law, law.fit).encode()
    files["identification.json"] = identification_json(identification).encode()
    files["identification.html"] = identification_page(identification, drawings).encode()
    write_document(folder, files, "identification.json")


def _not_verified(measured: Sequence[Run], *, has_bench: bool) -> str:
    if not has_bench:
        return (
            "these laws are not verified in closed loop, which needs a bench file; errors on runs "
            "that were left out of the fits are given where there are three such runs or more"
        )
    if not measured:
        return (
            "these laws are not verified: the campaign has no usable run of kind 'verification'. "
            "Add the experiment of that kind from configs/dynamics.yaml to the schedule"
        )
    if any(run.plan.motion is None or run.v_ref_m_s is None for run in measured):
        return (
            "these laws are not verified: the campaign does not contain the reference profile of "
            "its verification runs (imported logs have none)"
        )
    return ""

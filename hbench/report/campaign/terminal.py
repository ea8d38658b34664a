"""Results for a terminal: runs, reasons for rejection, and a line for each curve."""

from collections import Counter

from hbench.records import KINDS, Curve, Fit, JointFit, Results
from hbench.records.rod_pressure import without_common_rod_pressure
from hbench.report.campaign.motion_rows import motion_lines
from hbench.report.campaign.reasons import reason_counts
from hbench.report.campaign.series_words import kind_words, load_words
from hbench.report.render.numbers import short, span


def summary_text(results: Results) -> str:
    """Return runs, reasons, and a line for each curve."""
    accepted = sum(run.accepted for run in results.runs)
    reasons = ", ".join(f"{n} {code}" for code, n in reason_counts(results).most_common())
    rejected = f"{len(results.runs) - accepted} rejected" + (f" ({reasons})" if reasons else "")
    kinds = Counter(KINDS[run.run.plan.kind] for run in results.runs)
    several = len(kinds) > 1 or not all(kind.has_constant_speed for kind in kinds)
    kind_counts = ", ".join(f"{count} {kind.display_name}" for kind, count in kinds.items())
    of_kinds = f" ({kind_counts})" if several else ""
    rows = [["direction", "load", "speeds mm/s", "friction N", "fit"]]
    for curve in without_common_rod_pressure(results.curves):
        rows.append(
            [
                " ".join(filter(None, (curve.label, kind_words(curve), curve.direction))),
                load_words(curve.f_load_n, curve.p_lr_ref_pa) or "not set",
                span([1e3 * abs(point.v_m_s) for point in curve.points]),
                _friction_words(curve),
                "; ".join(_fit_words(fit) for fit in curve.fits[:1]) or "-",
            ]
        )
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]
    head = f"{results.provenance.name} ({results.provenance.source})"
    counts = f"{len(results.runs)} runs{of_kinds}: {accepted} accepted, {rejected}"
    notes = [f"note: {note}" for note in results.notes]
    lines += [_joint_words(joint) for joint in results.joint_fits]
    table = ["", *lines] if results.curves else []
    moving = motion_lines(results.motions)
    text = "\n".join([head, counts, *table, *([""] if moving else []), *moving, *notes])
    text = text.replace("−", "-").replace("²", "^2")
    return text.replace("–", " to ")  # not every terminal can show them


def _friction_words(curve: Curve) -> str:
    """Write friction against the motion; negative where it acts with the motion."""
    sign = 1 if curve.direction == "extend" else -1
    if len(curve.points) != 1:
        return span([sign * point.friction_n for point in curve.points])
    (point,) = curve.points
    return short(sign * point.friction_n) + (f" +- {short(point.ci95_n)}" if point.ci95_n else "")


def _joint_words(joint: JointFit) -> str:
    label = f"{joint.label}: " if joint.label else ""
    return f"{label}all {joint.curves} curves at once: " + "; ".join(map(_fit_words, joint.fits))


def _fit_words(fit: Fit) -> str:
    parameters = [
        f"{name}={short(value.value)}" + (f" (at {value.at_bound} bound)" if value.at_bound else "")
        for name, value in fit.parameters.items()
    ]
    return " ".join([fit.law, *parameters, *([] if fit.converged else ["NOT CONVERGED"])])

"""An identified law as a plant file: what ``--plant`` takes, and a bench file's friction.test."""

import yaml

from hbench.records import Fit, FitParameter, Identification, IdentifiedLaw


def overlay_yaml(identification: Identification, law: IdentifiedLaw, fit: Fit) -> str:
    """Return the text of the file: where it comes from as a comment, then the section."""
    provenance = identification.provenance
    lines = [
        f"Friction of the test cylinder, law {law.law}, identified by `hbench identify` from",
        f"{len(law.runs)} runs of the {provenance.source} campaign {provenance.name!r} of "
        f"{provenance.started}.",
        "Give it to `hbench run --plant`, or put the section into a bench file. The load",
        "cylinder's friction is not identified. Scatter from stroke to stroke is not in it.",
        "",
        f"rms of the fit {fit.rmse_n:.3g} N; values and 95 % intervals:",
        *(f"  {name} = {_value(p)}" for name, p in fit.parameters.items()),
    ]
    if fit.message:
        lines += ["", *fit.message.split("; ")]
    head = "".join(f"# {line}".rstrip() + "\n" for line in lines)
    body = yaml.safe_dump({"friction": {"test": law.section}}, sort_keys=False)
    return f"{head}\n{body}"


def _value(parameter: FitParameter) -> str:
    text = f"{parameter.value:.4g} {parameter.unit}".strip()
    if parameter.at_bound:
        return f"{text} (at its {parameter.at_bound} bound)"
    if parameter.ci95 is None:
        return f"{text} (not determined)"
    low, high = parameter.ci95
    remark = "" if parameter.determination == "determined" else f", {parameter.determination}"
    return f"{text} ({low:.4g} to {high:.4g}{remark})"

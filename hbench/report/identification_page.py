"""The page of an identification."""

from collections.abc import Iterable

from hbench.records import Identification
from hbench.report.document import Section, document
from hbench.report.figures import Drawing
from hbench.report.identification_text import reasons, tables

_SOURCE = (
    "Equation and section numbers: M. Hvoldal and C. Olesen, Friction Modelling and Parameter "
    "Estimation for Hydraulic Asymmetrical Cylinders, Aalborg University, 2011."
)
_SIMULATED = (
    "The campaign was made on the virtual rig: these numbers are simulated, and say nothing of a "
    "real cylinder."
)
_PARTS = (
    "Steady is where the reference has been the same speed for 0.3 s, rest where it has been zero "
    "for as long (there friction is whatever holds the piston)."
)
_SCATTER = (
    "The trials' scatter is what their mean, as a model, would leave; a part of it is how they "
    "begin, which a model that makes the same trials repeats."
)
_RAMPS = (
    "The source found a ramp's friction unlike the steady one (section 6.2): the last table has "
    "each fit on its own data and on the other's."
)


def identification_page(found: Identification, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    made = found.provenance
    simulated = [_SIMULATED] if made.source == "simulated" else []
    files = ", ".join(f"{law.law}.yaml" for law in found.laws if law.fit is not None)
    plants = f"As plant files beside this page: {files}. Give one to hbench run --plant, or put "
    read = [_PARTS, _SCATTER] if found.scatter else [] if found.not_verified else [_PARTS]
    read += [_RAMPS] if found.ramps else []
    words = (*simulated, *read, *found.notes, f"{plants}its section into a bench file.")
    laws = Section(paragraphs=words, tables=tables(found))
    missing = Section("What is missing or uncertain", items=reasons(found))
    figures = Section("Along the verification profile", drawings=tuple(drawings))
    return document(
        "Friction laws of the test cylinder",
        f"Campaign {made.name}, {made.source}, {made.started}; bench {made.bench}. {_SOURCE}",
        tuple(one for one in (laws, missing, figures) if one is not figures or figures.drawings),
        _verdict(found),
    )


def _verdict(found: Identification) -> str:
    if found.not_verified:
        return f"{found.not_verified[0].upper()}{found.not_verified[1:]}."
    return (
        "Each law, in a model of the bench with the firmware in closed loop, followed the profile "
        f"of the {len(found.verification_runs)} verification runs (section 5.5), which took no "
        "part in the identification."
    )

"""Order of identified laws by their errors of friction, and the one to be used."""

import math
from collections.abc import Iterable, Mapping

from hbench.records import Identification, IdentifiedLaw, ModelErrors
from hbench.records.identification import PARTS

AT_REST, AT_SPEED = "rest", "steady"  # of the parts of a verification run
IN_MOTION = tuple(part for part in PARTS if part != AT_REST)
_EQUALLY_GOOD = 1.05  # times the smallest error; the laws below are all named


def rms_n(parts: Iterable[ModelErrors]) -> float:
    """Return the root mean square error of friction [N] over parts of the runs; inf: none."""
    sampled = [part for part in parts if part.samples]
    squares = sum(part.samples * part.friction_n**2 for part in sampled)
    return math.sqrt(squares / sum(part.samples for part in sampled)) if sampled else math.inf


def in_motion_n(errors: Mapping[str, ModelErrors]) -> float:
    """Return the root mean square error of friction [N] while the piston moves; inf: unknown.

    At rest friction is the force that holds the piston, which laws of the speed alone do not
    determine: few samples there would decide the order of the laws.
    """
    return rms_n(errors[part] for part in IN_MOTION if part in errors)


def ranked_laws(identification: Identification) -> list[IdentifiedLaw]:
    """Return the laws, those with the smallest error of friction in motion first."""
    return sorted(identification.laws, key=error_n)


def error_n(law: IdentifiedLaw) -> float:
    """Return the error of friction [N] by which a law is ranked; inf: unknown."""
    return in_motion_n(law.errors) if law.errors else law.held_out_n or math.inf


def best_law(identification: Identification) -> str:
    """Return the law to be used; empty if none was verified.

    Of those with about the smallest error, it is the one with the fewest undetermined parameters.
    """
    errors = errors_in_motion(identification)
    fits = {law.law: law.fit for law in identification.laws if law.fit is not None}

    def undetermined(law: str) -> tuple[int, float]:
        return len(fits[law].undetermined) if law in fits else 0, errors[law]

    return min(equally_good(errors), key=undetermined, default="")


def equally_good(errors: Mapping[str, float]) -> dict[str, float]:
    """Return the laws with about the smallest error."""
    least = min(errors.values(), default=0.0)
    return {law: error for law, error in errors.items() if error <= _EQUALLY_GOOD * least}


def errors_in_motion(identification: Identification) -> dict[str, float]:
    """Return the error of friction in motion of each verified law."""
    return {law.law: in_motion_n(law.errors) for law in identification.laws if law.errors}

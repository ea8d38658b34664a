"""Errors of identified laws on motions that took no part in their fits.

Without a bench file there is no model of the bench to verify a law in. The law's friction along
the measured motion is then compared with the measured one, sample by sample.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hbench.analysis.identification.driven_law import driven_friction
from hbench.analysis.identification.identify import reverses
from hbench.analysis.screening.sample_friction import LoggedMotion
from hbench.config.friction import parse_friction
from hbench.model.build import friction_parameters
from hbench.records import IdentifiedLaw

_EVERY = 3  # of the motions, one is left out


def split_motions(
    motions: Sequence[LoggedMotion],
) -> tuple[list[LoggedMotion], list[LoggedMotion]]:
    """Return the motions to fit and those to leave out: every third of each sort.

    Motions with reversals and those without are counted separately; fewer than three are all
    fitted.
    """
    fitted: list[LoggedMotion] = []
    left_out: list[LoggedMotion] = []
    for reversing in (True, False):
        sort = [motion for motion in motions if reverses(motion) == reversing]
        for i, motion in enumerate(sort):
            (left_out if i % _EVERY == _EVERY - 1 else fitted).append(motion)
    return fitted, left_out


def with_held_out_errors(
    laws: Sequence[IdentifiedLaw], left_out: Sequence[LoggedMotion]
) -> tuple[IdentifiedLaw, ...]:
    """Return the laws with the root mean square errors of their friction along ``left_out``."""
    return tuple(
        replace(law, held_out_n=_error(law, left_out), held_out_runs=tuple(m.run for m in left_out))
        if law.fit is not None and left_out
        else law
        for law in laws
    )


def _error(law: IdentifiedLaw, motions: Sequence[LoggedMotion]) -> float:
    par = friction_parameters(parse_friction(law.section, law.law))
    errors = [(driven_friction(m, par) - m.friction_n)[m.compared] for m in motions]
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))

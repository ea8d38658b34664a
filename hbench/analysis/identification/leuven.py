"""Batch fit of the modified Leuven law's elements theta_i (3.14 to 3.20).

N elements with given Delta_max follow the logged motion by 3.15, and the law's friction is compared
with the measured one, as for LuGre.

The source's recursive estimate (3.21 to 3.24) is not offered. It learns in presliding only, where
the elements that do not slip yet move together: it finds their sum, not the single elements, and
its standard errors are no covariance of them. The batch fit uses sliding too.
"""

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from hbench.analysis.identification.lugre import UNKNOWNS, fit_to_motions, unknown
from hbench.analysis.screening.sample_friction import LoggedMotion
from hbench.model.friction.laws import LAWS
from hbench.model.parameters import FrictionParameters
from hbench.records import Fit

_SHAPES = {
    "delta_max_m": unknown("delta_max_m", 1e-5, 0.05, 1e-3),
    "n": unknown("n", 0.2, 5.0, 1.0),
}
STEADY = ("f_coulomb_n", "f_stiction_n", "v_stribeck_m_s", "b_viscous_n_s_m")
_SIZE_N = 100.0  # of an element
# Candidates for a start: multiples of the elements, multiples of Delta_max, and n.
_FACTORS, _SPANS, _EXPONENTS = (0.6, 1.0, 1.6), (0.5, 0.7, 1.0, 1.4, 2.0), (0.7, 1.0, 1.6)


def fit_leuven(
    motions: Sequence[LoggedMotion],
    known: FrictionParameters,
    names: Sequence[str],
    spans: Sequence[float] = _SPANS,
) -> Fit:
    """Fit all elements (non-negative) and the parameters in ``names``; others are as in ``known``.

    ``names`` are of LuGre's ``UNKNOWNS`` (without sigma_0), or ``delta_max_m`` and ``n``.
    ``known.elements`` specifies the number of elements and the start of the search. Delta_max and n
    are the user's unless ``names`` contains them; intervals are conditional on given values. There
    are several minima, so the search starts at several values, Delta_max at ``spans`` times the
    known. To choose between given values, compare the friction of held-out runs. Intervals are over
    whole runs, as for LuGre.
    """
    law = known._replace(law=LAWS["leuven"].code)
    n = len(law.elements)
    others = {name: {**UNKNOWNS, **_SHAPES}[name] for name in names}
    element = unknown("theta_i_n", 0.0, 1e5, _SIZE_N)
    elements = {f"theta_{i + 1}_n": element for i in range(n)}

    def put(x: np.ndarray) -> FrictionParameters:
        new = zip(others.values(), x[n:].tolist(), strict=True)
        values: dict[str, Any] = {u.field: value for u, value in new}
        return law._replace(elements=tuple(x[:n].tolist()), **values)

    spans = spans if "delta_max_m" in others else (1.0,)
    shapes = _EXPONENTS if "n" in others else (law.shape,)
    starts = []
    for span, shape in product(spans, shapes):
        scaled = law._replace(presliding=span * law.presliding, shape=shape)
        fixed = [getattr(scaled, u.field) for u in others.values()]
        starts.append([np.array([*(f * e for e in law.elements), *fixed]) for f in _FACTORS])
    return fit_to_motions("leuven", motions, put, elements | others, starts)

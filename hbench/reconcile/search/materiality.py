"""Which residuals matter: those above the limit below which a deviation is not material."""

from collections.abc import Collection

import numpy as np

from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.window_sums import MOTIONS, window_motions

_FEWEST = 5  # windows


def matters(residuals: GapMap, balances: Collection[str], points: np.ndarray) -> bool:
    """Return whether residuals of some balances matter at the operating points of these indices.

    Their root mean square, without the noise of single windows, then exceeds the limit over all
    windows, or over those of one motion: an effect may act in reversals alone. True where no limit
    is known, as where strokes are compared.
    """
    if residuals.material is None or residuals.white is None:
        return True
    own = np.isin(residuals.names, list(balances))
    chosen = residuals.select_points(points)
    square = ((chosen.difference / chosen.scatter) ** 2)[:, own]
    limit = (residuals.white + residuals.material**2)[own]
    motion = window_motions(chosen)
    for windows in (np.ones(len(motion), bool), *(motion == k for k in range(len(MOTIONS)))):
        count = np.isfinite(square[windows]).sum(axis=0)
        mean = np.nansum(square[windows], axis=0) / np.maximum(count, 1)
        if np.any((mean > limit) & (count >= _FEWEST)):
            return True
    return False

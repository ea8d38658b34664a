"""Steps of a log: the uncertainty of a channel's mean where its values are rounded coarsely.

Values with noise of the standard deviation s, rounded to steps q, have a mean whose error depends
on the place x of the true mean between two steps:

    error = q / pi exp(-2 pi^2 s^2 / q^2) sin(2 pi x / q) + higher harmonics
    u     = q / sqrt 12 exp(-2 pi^2 s^2 / q^2)

(B. Widrow and I. Kollar, Quantization Noise, 2008, 4.3; JCGM 100, F.2.2.1 without noise). Noise of
half a step is enough to average the rounding out. s is that of the samples less the rounding's own
part, s^2 = S^2 - q^2 / 12 (Sheppard). Between a tenth and a half of a step, this u is up to three
times too large.
"""

import numpy as np

from hbench.analysis.screening.friction_channels import friction_channels
from hbench.motion.noise import resolution
from hbench.records import Run

_LEAST = 0.01  # of friction; a smaller part of its uncertainty is neglected


def rounding_errors(run: Run, window: slice, friction_n: float) -> dict[str, float]:
    """Return the standard uncertainty of each mean over ``window`` by the log's steps, in SI.

    Only channels whose part in ``friction_n`` [N] matters are contained. The steps are those of the
    whole run, since a settled pressure may have one value in the window.
    """
    specimen = run.plan.specimen
    slopes = {"p_tp_pa": specimen.area_piston_m2, "p_tr_pa": specimen.area_rod_m2}
    found = {}
    for name in friction_channels(run):
        values = getattr(run, name)
        if values is not None:
            u = rounding_error(values[window], resolution(values))
            if u * slopes.get(name, 1.0) > _LEAST * abs(friction_n):
                found[name] = u
    return found


def rounding_error(values: np.ndarray, step: float) -> float:
    """Return the standard uncertainty of the mean of ``values`` (n,) that are rounded to ``step``.

    0 for a step of 0.
    """
    if step == 0.0:
        return 0.0
    noise = max(float(np.var(values)) / step**2 - 1 / 12, 0.0)
    return step / float(np.sqrt(12)) * float(np.exp(-2 * np.pi**2 * noise))

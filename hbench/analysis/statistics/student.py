"""Student's factor for two-sided 95 % intervals."""

from scipy.special import stdtrit


def student_factor(dof: float) -> float:
    """Return t with P(|T| <= t) = 0.95 for ``dof`` degrees of freedom.

    4.303 for the two degrees of freedom of three trials (equation 6.3; the 3.182 printed there
    belongs to three).
    """
    return float(stdtrit(dof, 0.975))

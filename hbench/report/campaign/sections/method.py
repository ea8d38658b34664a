"""Method of each number of the page: its equation and the source."""

from hbench.records import KINDS, Results
from hbench.records.friction_laws import FRICTION_LAWS, FrictionLaw
from hbench.report.campaign.quality.verdict import RULE
from hbench.report.render.document import Section

SOURCE = (
    "Equation numbers are those of the source of the method, M. Hvoldal and C. Olesen, Friction "
    "Modelling and Parameter Estimation for Hydraulic Asymmetrical Cylinders, Aalborg University, "
    "2011. Methods without a number are hbench's own."
)


def method_section(results: Results) -> Section:
    """Return the methods of the numbers that this campaign has."""
    analyses = {KINDS[curve.kind].analysis for curve in results.curves}
    laws = {fit.law for curve in results.curves for fit in curve.fits}
    laws |= {fit.law for joint in results.joint_fits for fit in joint.fits}
    motions = results.motions
    reduction = results.oil_temperature.reduction if results.oil_temperature else None
    efficient = any(p.efficiency is not None for c in results.efficiency for p in c.points)
    selections = [curve.selection for curve in results.curves]
    selections += [joint.selection for joint in results.joint_fits]
    applies = {
        "Drift": results.drift is not None,
        "Oil temperature": results.oil_temperature is not None,
        "Reduction to a reference temperature": reduction is not None,
        "Hersey number": any(p.hersey_m is not None for c in results.curves for p in c.points),
        "Instruments": _has_instruments(results),
        "Working speed": "steady_curve" in analyses,
        "Friction": bool(results.curves),
        "Breakaway": "ramp_curve" in analyses or "tustin" in laws or bool(motions.breakaways),
        **{_of_law(law): law.name in laws for law in FRICTION_LAWS.values()},
        "Parameters": bool(laws),
        "Which law predicts best": any(selections),
        "Friction of moving runs": bool(analyses - {"steady_curve"} or motions.loops),
        "Differences": bool(motions.comparisons),
        "Loops": bool(motions.loops),
        "Steps": bool(motions.levels),
        "Leakage": bool(motions.leakages),
        "Over the distance": bool(motions.over_distance),
        "Efficiency": efficient,
        "Half band and middle": bool(results.bands),
        "Energy of a cycle": any(band.energy_j is not None for band in results.bands),
        "Lines over pressure": bool(results.band_trends),
    }
    facts = {name: text for name, text in _NUMBERS.items() if applies.get(name, True)}
    if "Working speed" in facts:
        tolerance = 100 * results.headline.v_tolerance
        facts["Working speed"] = facts["Working speed"].format(tolerance=tolerance)
    return Section(
        "How each number was computed",
        (SOURCE,),
        facts=tuple(facts.items()),
        anchor="method",
        folded=True,
    )


def _has_instruments(results: Results) -> bool:
    """Return whether the tolerances of the instruments are known, so that they are part of U."""
    points = [point for curve in results.curves for point in curve.points]
    return any(point.sigma_instruments_n is not None for point in points) or any(
        each.u95_n is not None for each in results.motions.breakaways
    )


def _of_law(law: FrictionLaw) -> str:
    return f"Friction law: {law.title}"


_FITTED_TO = {
    "curve": "to each direction and load by itself.",
    "curves": "to the points of all loads and directions at once.",
    "motions": "to runs that reverse.",
}
_NUMBERS = {
    "Signs": "Positive velocity extends the cylinder. Positive F_L and F_applied oppose extension.",
    "Friction": "Of a run: the mean over its steady window of F_fT = P_Tp A_p − P_Tr A_r − "
    "F_applied (5.1).",
    "Point and interval": "A point is the mean of the accepted trials of one reference. Its 95 % "
    "interval is ± t s/√n with Student's t for n − 1 degrees of freedom (4.303 for three trials) "
    "and s the standard deviation of the trials. One trial has no interval.",
    "Instruments": "σ of friction by first-order propagation (6.15) of the instruments' errors "
    "through 5.1. A tolerance a is a limit unless the bench file says otherwise: its standard "
    "uncertainty is a/√3 (JCGM 100, 4.3.7). U = k √(s²/n + σ²), with Student's t at 95 % as k "
    "for the effective degrees of freedom of Welch and Satterthwaite, or k = 2 if the bench file "
    "asks for it. An instrument's error is "
    "the same in all points: it shifts a curve and changes its shape little.",
    "Drift": "Least squares of friction over the start times of the runs, with a level of each "
    "point (fixed effects): only deviations from a point's own mean count. They are taken as a "
    "share of friction or in N, whichever the scatter of the trials follows. Student's t has "
    "trials − points − 1 degrees of freedom. VIF is the variance of run time within a curve over "
    "that within its points; the share between speeds is the part of the drift that appears "
    "between a curve's slowest and fastest speed. With a VIF above 5 or a share above 25 %, time "
    "is not separated from speed. A significant drift d with standard error u(d) adds u = "
    "|t_point − t_mean| "
    "√(d² + u(d)²) to a point's interval: U² + (1.96 u)² (JCGM 100:2008, F.2.4.5 and "
    "equation 10). The drift is taken as a straight line over time.",
    "Oil temperature": "Of a run: the mean over its steady window, of the sensor nearest to the "
    "seal that all accepted steady runs have.",
    "Reduction to a reference temperature": "Viscosity η = ν ρ from the two points of the oil's "
    "record by ASTM D341, log log (ν + 0.7) = A − B log T. With r = η(T)/η(T_ref), the deviations "
    "of a point's trials from their mean are fitted by (c_0 + c_1 |v|) times those of r, by least "
    "squares for all loads of a direction: c_1 is viscous friction at the reference temperature if "
    "the record is right, c_0 the part that depends on viscosity at any speed. Reduced friction "
    "is that measured less (c_0 + c_1 |v|)(r − 1); its uncertainty contains that of c_0 and c_1. "
    "Friction is left as measured where the order of the runs does not separate temperature from "
    "speed (variance inflation of r above 5), where the reference temperature is further away than "
    "the measured range is wide, and where the correction is less than its uncertainty and this is "
    "above 5 % of friction.",
    "Hersey number": "η |v| / p with the higher of the two chamber pressures, which presses on the "
    "piston seal; the preload of the seal is not included. Divided by the width of the contact, "
    "which is not known, it would have no dimension (M. D. Hersey, 1914).",
    "Working speed": "The median of the measured speeds, or the value of --speed. The measured "
    "point next to it is used, up to a distance of {tolerance:g} %; nothing is interpolated. Where "
    "all curves have a single speed, each has its own unless --speed is given.",
    "Breakaway": "Runs of the kind breakaway: the largest friction while F_T rises at a stated "
    "rate on a piston that has rested under load, averaged over its noise; the longest rest "
    "leads. It depends on the rate and the rest, which are stated. Without such runs: F_s of "
    "Tustin's law (3.2), extrapolated to rest; its interval combines the "
    "parameter's with the instruments' at the slowest point. Without such a fit: the largest "
    "friction of the slowest ramp's first 20 mm, as the mean of its bin of velocity, where "
    "friction has fallen already. Neither is measured at rest.",
    **{
        _of_law(law): f"{law.formula} ({law.equations}), fitted by least squares within bounds "
        + _FITTED_TO[law.data]
        for law in FRICTION_LAWS.values()
    },
    "Parameters": "95 % intervals by profile likelihood. At a bound an interval has one side. "
    "A parameter is not determined if it has no interval, or if the half-width of its interval, "
    "linearised or by profile (the wider counts), exceeds a tenth of its typical size, and exceeds "
    "its value too or is cut off by a bound of the fit. It is hardly determined if its interval "
    "contains 0 or has a half-width of more than half of its value. "
    "The two intervals differ where a law is nonlinear within them or a bound is near. Correlated "
    "parameters do not vary by themselves: covariances.csv contains their covariances. Few points "
    "shift the estimates (Box 1971): fits.csv contains this bias, which is not corrected.",
    "Which law predicts best": "Each speed but the lowest and the highest is held out in turn and "
    "predicted from the others; two laws differ significantly where the 95 % interval of the "
    "difference of their mean squares is above zero.",
    "Friction of moving runs": "F_T − F_applied − m_T a (2.12 with the test side's mass, since the "
    "load cell carries the load side's). Velocity and acceleration are derivatives of the "
    "position, without lag.",
    "Differences": "Each trial's mean friction over the lower and the upper half of the speeds "
    "common to all, from breakaway on. Accelerations: F test of the analysis of variance. Ramp "
    "against steady: Welch's test. p is corrected after Holm for the number of tests.",
    "Loops": "Energy is the integral of F dx over a cycle. Width at a velocity is |F| while the "
    "speed rises less |F| while it falls. The board's velocity has its filter's lag; the table's "
    "last column shows the width over that velocity.",
    "Steps": "Settled friction is the mean of the second half of a level; the overshoot is the "
    "largest excess of friction over it, where it exceeds the noise.",
    "Leakage": "From the decay of both chambers' pressures with all valves closed, V/β dp/dt less "
    "the flow displaced by the piston; conditional on the stated effective bulk modulus and "
    "volumes. Leaks are proportional to the pressure, or to a power of it where the holds show "
    "one.",
    "Over the distance": "The distance is that of all logs and of the ways back to the next start. "
    "The friction of a cycle is the work against it, from rest to rest, over its distance. "
    "Student's t has the number of values − 2 degrees of freedom.",
    "Efficiency": "F_applied/F_T (6.10) where the oil drives the load, and its inverse where the "
    "load drives the oil. Its σ comes from the same errors by first-order propagation (6.16 to "
    "6.19); all points share it, so that a mean over speeds does not reduce it. ± is U, of "
    "trials and instruments as that of friction. The source takes tolerances themselves as "
    "standard uncertainties; the table of all points contains that σ in a separate column.",
    "Half band and middle": "(F_extend − F_retract)/2 and (F_extend + F_retract)/2. A constant "
    "error in force shifts both directions alike and cancels in the half band, but shifts the "
    "middle. Both are formed in each trial of both directions; their intervals are Student's over "
    "the trials. Strokes that were cut from a cycle are compared at the positions that both "
    "directions cover.",
    "Energy of a cycle": "The integral of (F_T − F_applied) dx over a whole stroke in each "
    "direction, reversals included, for trials with complete logs. The inertia's work is zero "
    "from rest to rest.",
    "Lines over pressure": "Least squares through the means of the pressures. The half-width of "
    "the 95 % interval is the root sum of squares of two: Student's from the residuals (number of "
    "pressures − 2 degrees of freedom), and Student's over the lines of the single trials. The "
    "first contains set-ups that differ from pressure to pressure, the second set-ups that differ "
    "from trial to trial.",
    "Verdict on the data": RULE,
}

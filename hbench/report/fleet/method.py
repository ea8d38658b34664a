"""How the numbers of a fleet's page are computed."""

from collections.abc import Iterator

from hbench.records import Fleet
from hbench.records.numbers import SIGNIFICANCE

_METHOD = (
    (
        "Numbers",
        "Each number is that of the campaign's report. Where a direction has several loads, it is "
        "the mean over them, provided that all of them have the number; its interval is as wide "
        "as the mean of theirs, as if their errors were the same. A fitted parameter that "
        "a campaign's data do not determine is left out, so that a number can have fewer campaigns "
        "than the fleet. Half band, middle and energy of a cycle are those at the "
        "median of the campaign's pressures.",
    ),
    (
        "Compared",
        "Only campaigns of the same kind: bench and origin of the data, areas of piston and rod "
        "side, loads and working speed. "
        "Where no speed was set, as in strokes cut from a cycle, a campaign counts if its speed is "
        "within 20 % of their median. A single label names the cylinder and may differ. "
        "The page evaluates those of the most frequent kind; analyze the others in a separate "
        "call.",
    ),
    (
        "Spread",
        "A campaign's number is taken as m + b + e: b with σ between campaigns, e with σ of the "
        "campaign's own trials: the root mean square of their standard errors, and its own for a "
        "campaign whose trials scatter more than three times as much as is usual. m is the "
        "median. σ between campaigns is such that the median of |x − m| / √(σ_between² + "
        "σ_own²) is 0.6745: up to half of the campaigns may deviate by any amount. Its 95 % "
        "interval is by the quantiles of χ² with 0.37 (n − 1) degrees of freedom, for normal "
        "values; from 10 campaigns on. Errors of the instruments are common to a bench's campaigns "
        "and are not included.",
    ),
    (
        "Outliers",
        "The deviation is (x − m) / √(σ_between² + σ_own²); where the mean has a step, m is the "
        "median of the campaigns before or after it, and where a number drifts, its trend line. "
        "p is that of Student's distribution with 0.37 (n − 1) degrees of freedom, "
        "times the number of campaigns and numbers (Bonferroni): among good cylinders alone, one "
        f"fleet in twenty has an outlier. An outlier has p below {SIGNIFICANCE:g}; at least 10 "
        "campaigns are needed.",
    ),
    (
        "Trends",
        "Theil and Sen's line, its interval and p by Kendall's rank correlation, corrected after "
        "Holm for the number of trends. A trend is called a drift where p is below "
        f"{SIGNIFICANCE:g}. It does not distinguish a change of the cylinders from a change "
        "of the bench.",
    ),
    (
        "Repeatability and reproducibility",
        "A number is the sum of a mean, an effect of each factor that the plan varies, and "
        "the scatter of the trials. The variances are estimated by REML; their intervals are those "
        "of the profile likelihood, at 95 %. ANOVA (Henderson III) gives the same in a balanced "
        "plan where no estimate is negative. s_r is the standard deviation of the trials of one "
        "campaign, s_R that of single trials under all conditions of the plan: everything but the "
        "cylinders. The limits r = 2.8 s_r and R = 2.8 s_R are exceeded by the difference of two "
        "single trials in 5 % of cases (ISO 5725-6); two campaigns of n trials each may differ by "
        "√(R² − r² (1 − 1/n)). Effects are taken as normal: heavy tails make the intervals too "
        "narrow. A factor with two or three levels has a wide interval. "
        "Mountings are those of one cylinder. Errors of the instruments are common to all "
        "campaigns of a bench and are not included.",
    ),
    (
        "Share of tolerance",
        "%GRR is s_R over the standard deviation of all sources, or 6 s_R over the width of the "
        "tolerance (--tolerance). By the AIAG's rule up to 10 % is good and above 30 % not "
        "acceptable. The number of distinct categories (ndc) is 1.41 times the standard deviation "
        "between cylinders over s_R; at least 5 are asked for.",
    ),
    (
        "Capability",
        "Ppk = min(upper limit − mean, mean − lower limit) / (3 s); s is the standard deviation of "
        "all campaigns. Cpk has s_w in the place of s: the mean moving range / 1.128, in the order "
        "of the dates. Both contain the measurement's scatter. The 95 % intervals are Bissell's, "
        "for normal values, with n − 1 and 0.605 (n − 1) degrees of freedom. At least 10 "
        "campaigns of the same kind are needed. Values are those of hbench accept, which measures "
        "what a limit applies to; for a limit of all loads at the working speed, those of the "
        "table of campaigns.",
    ),
    (
        "Control charts",
        "Individual values with moving ranges (ISO 7870-2): the limits are the mean ± 3 σ with "
        "σ = mean moving range / 1.128; the limit of the moving range is 3.267 times its mean. "
        "Where the mean has a significant step, mean and σ are those of the campaigns before it. "
        "The rules are those of Western Electric (1956) and Nelson (1984), each by its number. "
        "The EWMA is z_i = λ x_i + (1 − λ) z_i−1 with λ = 0.1; its limits are the mean ± L σ "
        "√(λ/(2 − λ) (1 − (1 − λ)²ⁱ)) with L = 2.7 (Montgomery). Where several cylinders "
        "were measured three times or more, the charts show the deviation from their own mean, "
        "scaled by √(n/(n − 1)). At least 10 campaigns with a date are needed. Without any "
        "change a false signal comes in the mean every 370 points beyond 3 σ, every 356 by the "
        "EWMA, and every 78 by any of the individuals chart's rules; more often where few "
        "campaigns determine mean and σ.",
    ),
    (
        "Change points",
        "The most likely step of the mean: the split into two parts with the largest likelihood "
        "ratio, at least three campaigns each. p is that of a permutation test with 1999 random "
        "orders of a fixed seed, corrected after Holm for the number of charts. A steady drift "
        "appears as a step, too. The interval of a step is that at the chosen campaign.",
    ),
    (
        "Wear",
        "Distance and friction work are those of the logged runs of a cylinder's campaigns, summed "
        "in the order of their dates; motion between the runs is not logged and not included. "
        "Rejected runs count with the mean friction of the accepted ones. The "
        "line is a least-squares line, its interval Student's at 95 %, p is corrected after Holm "
        "for the number of lines. At least 4 campaigns of a cylinder are needed. Whatever else "
        "changes with time, such as the oil, appears as wear too.",
    ),
    (
        "All rows",
        "fleet.parquet beside this page has a row for each campaign, with the interval of each "
        "number.",
    ),
)


def fleet_method(fleet: Fleet) -> Iterator[tuple[str, str]]:
    """Yield the methods of the results that the page has."""
    absent = {
        "Repeatability and reproducibility": not fleet.precision,
        "Share of tolerance": all(s.share_of_tolerance is None for s in fleet.precision),
        "Capability": not fleet.capabilities,
        "Control charts": not fleet.charts,
        "Change points": not fleet.charts,
        "Wear": not fleet.wear,
    }
    for name, words in _METHOD:
        if not absent.get(name):
            yield name, words

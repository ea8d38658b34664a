"""Names of a fleet's numbers and campaigns, and signs."""

from hbench.records import (
    DIRECTION_WORDS,
    FEWEST_CAMPAIGNS,
    ControlChart,
    Deviation,
    Fleet,
    Precision,
    Quantity,
    Side,
    Spread,
    WearTrend,
)
from hbench.records.fleet.campaign_names import distinct_names
from hbench.report.render.numbers import NONE, short
from hbench.sentences import uncapital

WORKING_SPEED = " at the working speed"
Shown = Spread | Deviation | Precision | ControlChart | WearTrend


def campaign_names(fleet: Fleet) -> dict[str, str]:
    """Return the name of each campaign of the fleet's tables, by its path."""
    paths = [row.path for row in fleet.rows] + [suspect.path for suspect in fleet.worst]
    return distinct_names(list(dict.fromkeys(paths)))


def name_of(number: Shown) -> str:
    """Return the number's words with direction and unit."""
    title = without_condition(number.quantity)
    return f"{title}{of_side(number.direction)} ({number.quantity.unit})"


def without_condition(quantity: Quantity) -> str:
    """Return the quantity's words without the speed or pressure that it is taken at."""
    words = quantity.words
    for condition in (WORKING_SPEED, " at the median pressure"):
        words = words.removesuffix(condition)
    return words


def in_sentence(quantity: Quantity) -> str:
    """Return the quantity's words as ``without_condition``, within a sentence."""
    return uncapital(without_condition(quantity))


def short_title(quantity: Quantity) -> str:
    """Return the quantity's words as ``without_condition``, up to the first comma."""
    return without_condition(quantity).partition(",")[0]


def range_words(campaigns: int) -> str:
    """Return what the low and the high end of a spread of so many campaigns are."""
    if campaigns == 1:
        return "one campaign"
    if campaigns < FEWEST_CAMPAIGNS:
        return f"smallest to largest of {campaigns} campaigns"
    return "5 to 95 % of the campaigns"


def of_side(side: Side) -> str:
    """Return ``, extending`` or ``, retracting``; empty for both directions together."""
    return "" if side is None else f", {DIRECTION_WORDS[side]}"


def of_change(unit: str) -> str:
    """Return the unit of a change: percentage points of a number in per cent."""
    return "percentage points" if unit == "%" else unit


def signed(text: str) -> str:
    """Return a number with its sign, and none before a zero."""
    return text if text.startswith(("−", "0", NONE)) and not text.startswith("0.") else f"+{text}"


def working_speed(fleet: Fleet) -> str:
    """Return the working speed of the compared campaigns; empty if unknown or not the same."""
    speeds = {row.v_m_s and short(1e3 * row.v_m_s) for row in fleet.rows if row.compared}
    (speed,) = speeds if len(speeds) == 1 else (None,)
    return f"{speed} mm/s" if speed else ""


def main_spreads(fleet: Fleet) -> list[Spread]:
    """Return the numbers to show first: those of friction bands, or else of each direction."""
    listed = [spread for spread in fleet.spreads if spread.quantity.listed]
    return [spread for spread in listed if spread.direction is None] or listed

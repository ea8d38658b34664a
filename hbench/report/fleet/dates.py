"""Axes of a fleet's figures: dates of the campaigns, or their order where they have none."""

from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from hbench.records import Fleet
from hbench.report.render.series import DaysAsDates

_TICKS = 4  # distances between the dates below a figure, at most
_HOURS = 2.0  # days: campaigns closer together are shown with the time of day


def set_dates(axes: Axes, fleet: Fleet) -> None:
    """Label the abscissa, which is in days since the first campaign, with dates.

    Without dates it is the number of the campaign in the order of the paths.
    """
    if not fleet.by_date or fleet.first is None or fleet.last is None:
        axes.xaxis.get_major_locator().set_params(integer=True)
        axes.set_xlabel("Number in order of path")
        return
    days = (fleet.last - fleet.first).total_seconds() / 86_400
    hours = days < _HOURS
    axes.xaxis.set_major_locator(MaxNLocator(_TICKS, integer=not hours))
    axes.xaxis.set_major_formatter(DaysAsDates(fleet.first, hours))
    axes.set_xlabel("Start of the campaign (UTC)")

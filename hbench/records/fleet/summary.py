"""Summary of a fleet of campaigns."""

from dataclasses import dataclass
from datetime import datetime

from hbench.records.conformity.acceptance import Requirement
from hbench.records.fleet.campaigns import FleetCampaign
from hbench.records.fleet.population import Spread, Suspect, WearTrend
from hbench.records.fleet.precision import Precision
from hbench.records.fleet.process_control import Capability, ControlChart


@dataclass(frozen=True)
class Fleet:
    """Summary of a table of campaigns. Its size does not depend on their number."""

    campaigns: int
    failed: int
    reasons: tuple[tuple[str, int], ...]  # why, and how many; the most frequent first
    failures: tuple[tuple[str, str], ...]  # path and reason, of the first ones
    qualities: tuple[tuple[str, int], ...]
    incomplete: int  # campaigns
    sources: tuple[tuple[str, int], ...]
    protocols: tuple[tuple[str, int], ...]  # the most frequent is evaluated
    compared: int  # campaigns of that protocol, at its speed
    other_speeds: int  # campaigns of that protocol whose speed, not set, differs by more than 20 %
    copies: int  # analyzed campaigns with the logs of another, which are not compared
    by_date: bool  # blocks and trends are over days since ``first``; else over the order of paths
    first: datetime | None
    last: datetime | None
    spreads: tuple[Spread, ...]
    outliers: int
    worst: tuple[Suspect, ...]  # the most deviating, outliers or not
    # Repeatability and reproducibility, where the campaigns form a plan; and why not, or not all.
    precision: tuple[Precision, ...] = ()
    plan_notes: tuple[str, ...] = ()
    # Checks of the data that give campaigns their grade, unless that is good: how many campaigns.
    weak_checks: tuple[tuple[str, int], ...] = ()
    drift_possible: float | None = None  # largest share of friction that a drift may hide in one
    charts: tuple[ControlChart, ...] = ()
    wear: tuple[WearTrend, ...] = ()
    capabilities: tuple[Capability, ...] = ()
    without_capability: tuple[tuple[Requirement, str], ...] = ()  # a limit, and why it has no Ppk
    decisions: tuple[tuple[str, int], ...] = ()  # of the last acceptances, and how many of each
    rows: tuple[FleetCampaign, ...] = ()  # analyzed campaigns; empty for a large fleet

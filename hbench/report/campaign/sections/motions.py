"""Sections of ramps, breakaway, hysteresis, steps, leakage and friction over the distance."""

from collections.abc import Callable, Iterator
from dataclasses import replace

from hbench.records import Results
from hbench.report.campaign import page_motions
from hbench.report.campaign.motion_rows import differs
from hbench.report.campaign.quality.verdict import instruments_percent
from hbench.report.creep_words import creep_facts
from hbench.report.render.document import Section
from hbench.report.render.figures import Drawing
from hbench.report.render.numbers import number, span
from hbench.report.render.word_tables import Table, titled
from hbench.sentences import counted, plural

_RAMPS = "Does the acceleration matter, and do ramps differ from steady runs?"
_BREAKAWAY = (
    "Breakaway is the largest friction while a rising force pushes the piston, which has rested "
    "under load. It depends on the seals, on the time at rest and on the rate of the force. The "
    "piston creeps while the force rises; creep is the distance up to the largest friction."
)
_HOLDS = "Oil that leaves the chambers in each hold, without U. [[leakage]] has the leaks with U."
_DISTANCE = (
    "Changes along straight lines with their 95 % intervals: over all values (endurance), and over "
    "the last half of them (run-in). Settled: the interval of the last change lies within 5 % of "
    "the mean. Changing: it is wider and does not contain 0."
)
_TESTED = (
    "Difference of friction over a range of speeds ± half-width of its 95 % interval "
    "over the trials. p is corrected after Holm for the number of tests."
)


def motion_sections(
    results: Results, drawn: Callable[[str], tuple[Drawing, ...]], decided: bool
) -> Iterator[Section]:
    """Yield a section for each kind of motion that the campaign has.

    ``drawn`` returns the figures of a section. A report with a decision, ``decided``, explains the
    breakaway there.
    """
    if drawings := drawn("ramps"):
        yield Section("Ramps", drawings=drawings, parts=_comparisons(results))
    if results.motions.breakaways:
        yield _breakaway(results, drawn("breakaway"), decided)
    if drawings := drawn("hysteresis"):
        loops = page_motions.loop_table(results)
        shown = _with_table("Hysteresis", "Width and energy of the loops", drawings, loops)
        yield _below(_loop_words(results), shown)
    if drawings := drawn("steps"):
        levels = page_motions.level_table(results)
        shown = _with_table("Steps", "Friction after each step", drawings, levels)
        yield _below(_step_words(results), shown)
    if drawings := drawn("leakage"):
        leaks = page_motions.leak_table(results)
        shown = _with_table("Leakage", "Leakage at the highest pressure", drawings, leaks)
        yield replace(shown, parts=_holds(results))
    if drawings := drawn("over-distance"):
        tables = titled(page_motions.distance_table(results), "Changes over the distance")
        yield Section("Over the distance", (_DISTANCE,), drawings=drawings, tables=tables)


def _comparisons(results: Results) -> tuple[Section, ...]:
    """Return the tested differences between ramps, if there are any."""
    table = page_motions.comparison_table(results)
    if not table.rows:
        return ()
    differing = sum(map(differs, results.motions.comparisons))
    are = plural(differing, "is", "are")
    title = f"{_RAMPS} {differing} of {len(table.rows)} differences {are} significant."
    tables = titled(table, "Differences between ramps, and from steady runs")
    return (Section(title, (_TESTED,), tables=tables, folded=True),)


def _breakaway(results: Results, drawings: tuple[Drawing, ...], decided: bool) -> Section:
    laws = "Laws over the time at rest, with the intervals of the trials"
    return Section(
        "Breakaway",
        (_BREAKAWAY,),
        drawings=drawings,
        facts=() if decided else creep_facts(results),
        tables=(
            *titled(page_motions.breakaway_table(results), "Measured breakaway force"),
            *titled(page_motions.dwell_table(results), laws),
        ),
    )


def _with_table(name: str, title: str, drawings: tuple[Drawing, ...], table: Table) -> Section:
    """Return a section of figures, a table with a title, and the table's messages."""
    tables = (replace(table, title=title),)
    return Section(name, items=table.messages, drawings=drawings, tables=tables)


def _below(text: str, section: Section) -> Section:
    """Return a section of a text, with the figure and table of another folded below it."""
    fold = f"{section.tables[0].title}: figure and table"
    inside = replace(section, title=fold, folded=True, printed=False)
    return Section(section.title, (text,), parts=(inside,))


def _holds(results: Results) -> tuple[Section, ...]:
    table = page_motions.hold_table(results)
    title = f"Each hold ({len(table.rows)})"
    return (Section(title, (_HOLDS,), tables=(table,), folded=True),) if table.rows else ()


def _loop_words(results: Results) -> str:
    loops = results.motions.loops
    runs = counted(sum(loop.trials for loop in loops), "triangle run")
    energy = span([loop.area_j for loop in loops])
    share = instruments_percent(results.quality)
    instruments = f", which make friction uncertain by ±{share} %" if share else ""
    return (
        f"{runs} with {energy} J of friction work a cycle. Intervals of energy and width do not "
        f"contain the instruments{instruments}. Width is |F| while the speed rises less |F| while "
        "it falls: it is negative where friction is larger while the speed falls."
    )


def _step_words(results: Results) -> str:
    levels = results.motions.levels
    speeds = span([1e3 * abs(level.v_to_m_s) for level in levels])
    known = [level.settling_s for level in levels if level.settling_s is not None]
    slowest = (
        f" The longest settling time of friction is {number(max(known), 2)} s." if known else ""
    )
    return f"{counted(len(levels), 'level')} of {speeds} mm/s.{slowest}"

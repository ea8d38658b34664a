"""An identification for a terminal: the verdict, the laws, and the parameters of the best one."""

from dataclasses import replace

from hbench.records import Identification, WordTable
from hbench.records.friction_laws import FRICTION_LAWS
from hbench.report.campaign.fit_tables import law_words
from hbench.report.identification.misfit_words import MISFIT
from hbench.report.identification.ranking import best_law
from hbench.report.identification.remarks import interval_words, left_out_words, oscillation_words
from hbench.report.identification.text import (
    HELD_OUT,
    PARAMETERS,
    SUMMARY,
    identification_tables,
    reasons,
    with_law_names,
)
from hbench.report.identification.verdict import verdict_words
from hbench.report.render.terminal_table import table_lines
from hbench.report.render.terminal_text import plain, wrapped

_TABLES = (SUMMARY, HELD_OUT, MISFIT, PARAMETERS)


def identification_text(identification: Identification) -> str:
    """Return the law to use, the errors of all laws, and what is known of the one to use.

    Without such a law, the parameters of all. The page has the other tables and remarks.
    """
    best = best_law(identification)
    others = {law.law for law in identification.laws if best and law.fit and law.law != best}
    verdict = wrapped(verdict_words(identification))
    blocks = ["\n".join(verdict)] if verdict else []
    for table in identification_tables(identification):
        if table.title in _TABLES:
            known = others if table.title == PARAMETERS else set()
            rows = tuple(row for row in table.rows if row[0] not in known)
            shown = with_law_names(replace(table, rows=rows))
            blocks.append("\n".join(table_lines(_of_one_law(shown) if known else shown)))
    remarks = [
        *(
            _remark(reason)
            for reason in reasons(identification)
            if reason.partition(":")[0] not in others
        ),
        *([f"At constant speed: {words}"] if (words := oscillation_words(identification)) else []),
        *_left_out(identification),
        interval_words(identification),
        *identification.notes,
    ]
    blocks.append("\n".join(line for remark in remarks for line in wrapped(remark)))
    return plain("\n\n".join(blocks))


def _of_one_law(table: WordTable) -> WordTable:
    """Return a table with the law of all its rows in its title."""
    rows = tuple(row[1:] for row in table.rows)
    return WordTable(f"{table.title} of {table.rows[0][0]}", table.head[1:], rows)


def _remark(remark: str) -> str:
    """Return a remark with its law's name in place of the key."""
    law, colon, rest = remark.partition(":")
    return f"{law_words(law)}{colon}{rest}" if law in FRICTION_LAWS else remark


def _left_out(identification: Identification) -> tuple[str, ...]:
    """Return how many runs are not used, and the reasons."""
    lines = [f"- {line}" for line in left_out_words(identification)]
    return (f"Runs not used: {len(identification.left_out)}", *lines) if lines else ()

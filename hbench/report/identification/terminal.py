"""An identification for a terminal: the verdict first, then every table and the remarks."""

from hbench.records import Identification
from hbench.records.friction_laws import FRICTION_LAWS
from hbench.report.campaign.fit_tables import law_words
from hbench.report.identification.remarks import interval_words, left_out_words
from hbench.report.identification.text import identification_tables, reasons, with_law_names
from hbench.report.identification.verdict import verdict_words
from hbench.report.render.terminal_table import table_lines
from hbench.report.render.terminal_text import plain, wrapped


def identification_text(identification: Identification) -> str:
    """Return the law to use, every table in aligned columns, then the remarks."""
    verdict = wrapped(verdict_words(identification))
    blocks = ["\n".join(verdict)] if verdict else []
    tables = map(with_law_names, identification_tables(identification))
    blocks += ["\n".join(table_lines(table)) for table in tables]
    remarks = [
        *map(_remark, reasons(identification)),
        *_left_out(identification),
        interval_words(identification),
        *identification.notes,
    ]
    blocks.append("\n".join(line for remark in remarks for line in wrapped(remark)))
    return plain("\n\n".join(blocks))


def _remark(remark: str) -> str:
    """Return a remark with its law's name in place of the key."""
    law, colon, rest = remark.partition(":")
    return f"{law_words(law)}{colon}{rest}" if law in FRICTION_LAWS else remark


def _left_out(identification: Identification) -> tuple[str, ...]:
    """Return how many runs are not used, and the reasons."""
    lines = [f"- {line}" for line in left_out_words(identification)]
    return (f"Runs not used: {len(identification.left_out)}", *lines) if lines else ()

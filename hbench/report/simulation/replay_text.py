"""A replay in words and as JSON."""

from dataclasses import asdict

from hbench.records import Replay, WordTable
from hbench.report.diagnosis.names import signal
from hbench.report.json_documents.values import json_text, json_value
from hbench.report.render.numbers import significant
from hbench.report.render.terminal_table import table_lines
from hbench.report.render.terminal_text import wrapped
from hbench.sentences import counted


def replay_text(replay: Replay) -> str:
    """Return the simulated runs, the error of each signal, and the runs left out."""
    rows = tuple(
        (
            signal(error.signal).title,
            error.unit,
            *(significant(n, 3) for n in (error.off, error.worst)),
        )
        + (error.worst_run,)
        for error in replay.off
    )
    head = ("signal", "unit", "all runs", "worst run", "which")
    lines = [
        *wrapped(
            f"SIMULATED: {counted(len(replay.runs), 'run')} of {replay.provenance.name!r} by "
            f"{replay.model}, in open loop: under the measured valve commands and supply pressure."
        ),
        "",
        *table_lines(WordTable("Simulated less measured, root mean square", head, rows)),
        *(line for words in replay.left_out for line in wrapped(f"left out: {words}")),
    ]
    return "\n".join(lines).replace("−", "-")


def replay_json(replay: Replay) -> str:
    """Return the replay as one object; the runs are in files."""
    document = {
        "schema": "hbench.replay/1",
        "simulated": True,
        "model": replay.model,
        "campaign": replay.provenance.name,
        "runs": [run.plan.run for run in replay.runs],
        "off": [asdict(error) for error in replay.off],
        "left_out": replay.left_out,
    }
    return json_text(json_value(document))

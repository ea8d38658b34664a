"""The page of a preview: the result, a section for each series, and a table of all files."""

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence

from hbench.records import ImportPreview, PreviewedChannel, PreviewedFile, PreviewedRun
from hbench.report.import_preview.figures import window_of
from hbench.report.import_preview.names import display, symbol, words
from hbench.report.render.document import Section, document
from hbench.report.render.figures import Drawing
from hbench.report.render.numbers import NONE, number, short, significant, with_interval
from hbench.report.render.word_tables import Cell, Table
from hbench.sentences import counted
from hbench.untrusted_text import printable

_MOST_RUNS = 60  # of a file in its table
_NO_COLUMN = {"t_s": "stated by the file"}
_LONG_STEP = 2.5  # times the median sampling interval: a gap


def preview_page(preview: ImportPreview, drawings: Mapping[str, Drawing]) -> str:
    """Return the page. ``drawings`` are figures by the names of their files."""
    errors = Section("Errors", items=tuple(_errors(preview)))
    rejected = Section("Rejected runs", tables=tuple(_reasons(preview)))
    parts = tuple(part for part in (errors, rejected) if part.items or part.tables)
    sections = [
        Section("Result", paragraphs=tuple(_result(preview)), parts=parts),
        *_series(preview, drawings),
        Section("All files", tables=(file_table(preview),)),
    ]
    return document(
        f"{printable(preview.name)}: preview of the import",
        f"Logs in {printable(preview.folder)}, read by the map {printable(preview.map_file)}. "
        "Nothing was imported.",
        tuple(sections),
        _verdict(preview),
    )


def _verdict(preview: ImportPreview) -> str:
    runs = preview.runs
    accepted = f"{sum(r.screened.accepted for r in runs)} of {counted(len(runs), 'run')}"
    errors = len(list(_errors(preview)))
    if preview.refused:
        return (
            f"The import would stop with {counted(errors, 'error')}, listed "
            f"below. Without these files, {accepted} would be accepted."
        )
    if errors:
        return (
            f"The import would leave out {counted(errors, 'file')}, listed below with the reasons. "
            f"Of the other files, {accepted} would be accepted."
        )
    files = counted(len(preview.files), "file")
    return f"{files} can be imported; {accepted} would be accepted."


def _result(preview: ImportPreview) -> Iterator[str]:
    words = {
        "none": "Each file is one run.",
        "reversals": "The files are cut at the reversals into strokes; each is a run.",
        "plateaus": "The files are cut at their constant speeds; each is a run.",
    }
    if len(preview.cuts) == 1:
        yield words[preview.cuts[0]]
    else:
        yield f"The series differ in cut: {', '.join(preview.cuts)}."
    if preview.unmatched:
        few = ", ".join(map(printable, preview.unmatched[:5]))
        more = f" and {len(preview.unmatched) - 5} more" if len(preview.unmatched) > 5 else ""
        yield f"Files that match no series of the map are left out: {few}{more}."


def _errors(preview: ImportPreview) -> Iterator[str]:
    for label, files in preview.empty_series.items():
        yield f"Series {printable(label)}: no file matches {printable(files)}"
    for file in preview.files:
        if file.error:
            yield f"{printable(file.name)}: {printable(file.error)}"


def _reasons(preview: ImportPreview) -> Iterator[Table]:
    """Yield the table of the reasons for rejection, the most frequent first."""
    by_code: dict[str, list[tuple[str, str]]] = defaultdict(list)
    for run in preview.runs:
        for code, text in {
            r.partition(":")[0]: r.partition(":")[2] for r in run.screened.reasons
        }.items():
            by_code[code].append((run.screened.run.plan.run, text.strip()))
    if not by_code:
        return
    rows = [
        (
            code.replace("_", " "),
            str(len(dict(found))),
            found[0][0].lstrip("0"),
            _with_symbols(found[0][1]),
        )
        for code, found in sorted(by_code.items(), key=lambda item: -len(dict(item[1])))
    ]
    head = ("Reason", "Runs", "First run", "Its value and limit")
    yield _table(head, rows, {"Reason", "Its value and limit"}, "")


def _series(preview: ImportPreview, drawings: Mapping[str, Drawing]) -> Iterator[Section]:
    for pattern in dict.fromkeys(file.pattern for file in preview.files):
        files = [file for file in preview.files if file.pattern == pattern]
        accepted, runs = sum(f.accepted for f in files), sum(len(f.runs) for f in files)
        about = (
            f"Files {printable(pattern)}: {counted(len(files), 'file')}, {accepted} of "
            f"{counted(runs, 'run')} accepted."
        )
        shown = [file for file in files if file.name in drawings]
        if len(shown) < len(files):
            about += " Shown are the first file and the first ones with other reasons to reject."
        yield Section(
            printable(files[0].series) or printable(pattern),
            paragraphs=(about,),
            parts=tuple(_file(file, drawings[file.name]) for file in shown),
        )


def _file(file: PreviewedFile, drawing: Drawing) -> Section:
    tables = [channel_table(file)]
    if file.runs:
        tables.append(run_table(file))
    return Section(
        printable(file.name),
        paragraphs=(_sampling(file),),
        items=tuple(_with_symbols(printable(note)) for note in file.notes),
        drawings=(drawing,),
        tables=tuple(tables),
    )


def _with_symbols(note: str) -> str:
    """Write the symbols of channels in place of their names in a map."""
    return re.sub(r"\b[a-z]\w*_[a-z]+\b", lambda match: symbol(match[0]), note)


def _sampling(file: PreviewedFile) -> str:
    text = f"{file.samples} samples in {short(file.duration_s)} s, {short(file.rate_hz)} Hz"
    if file.longest_step_s * file.rate_hz > _LONG_STEP:
        text += f", with a gap of {significant(file.longest_step_s, 3)} s"
    else:
        text += ", without gaps"
    if file.log is not None and file.log.rest_s is not None:
        start, stop = file.log.rest_s
        moves = stop - start < file.duration_s - 1.5 / file.rate_hz
        text += f"; at rest for {number(stop - start, 2)} s{moves * ' before the motion'}"
    return f"{text}."


def channel_table(file: PreviewedFile) -> Table:
    """Return the channels of a file: column, unit, range and zero offset."""
    rows: list[tuple[str | Cell, ...]] = [
        (
            symbol(channel.name),
            words(channel.name),
            printable(channel.column) or _NO_COLUMN.get(channel.name, "constant"),
            channel.unit_in_file,
            *_range(channel),
            _zero(channel),
        )
        for channel in file.channels
    ]
    head: tuple[str, ...] = (
        *("Channel", "Quantity", "Column", "Unit in the file", "Lowest", "Highest", "Unit"),
        "Zero offset subtracted (± standard error)",
    )
    text = {"Channel", "Quantity", "Column", "Unit in the file", "Unit"}
    if not any(channel.zero for channel in file.channels):
        head, rows = head[:-1], [row[:-1] for row in rows]
    return _table(head, rows, text, "Channels")


def _range(channel: PreviewedChannel) -> tuple[str | Cell, str | Cell, str]:
    unit, factor = display(channel.unit)
    flag = "" if not channel.gaps else f"{channel.gaps} samples missing"
    return (
        significant(factor * channel.lowest, 4),
        Cell(significant(factor * channel.highest, 4), flag),
        unit,
    )


def _zero(channel: PreviewedChannel) -> str:
    if channel.zero is None:
        return ""
    _, factor = display(channel.unit)
    se = None if channel.zero_se is None else factor * channel.zero_se
    return with_interval(factor * channel.zero, se)


def run_table(file: PreviewedFile) -> Table:
    """Return the runs of a file with their verdicts."""
    units = {channel.name: channel.unit for channel in file.channels}
    speed_unit, factor = display(f"{units.get('x_m', 'm')}/s")
    rows = [_run_row(run, factor) for run in file.runs[:_MOST_RUNS]]
    force_unit = units.get("f_applied_n", units.get("f_drive_n", "N"))
    head = (
        *("Run", "Trial", f"Nominal speed ({speed_unit})", f"Measured ({speed_unit})"),
        *("From (s)", "To (s)", f"Friction ({force_unit})", "Verdict"),
    )
    title = "Runs"
    if len(file.runs) > _MOST_RUNS:
        title += f": the first {_MOST_RUNS} of {len(file.runs)}"
    return _table(head, rows, {"Verdict"}, title)


def _run_row(run: PreviewedRun, speed_factor: float) -> tuple[str | Cell, ...]:
    screened, plan = run.screened, run.screened.run.plan
    means = screened.means
    start, stop = window_of(run)
    return (
        plan.run.lstrip("0"),
        str(plan.trial),
        significant(speed_factor * plan.v_ref_m_s, 4),
        NONE if means is None else significant(speed_factor * means.v_m_s, 4),
        number(start, 2),
        number(stop, 2),
        NONE if means is None else significant(means.friction_n, 4),
        "accepted" if screened.accepted else f"rejected: {_with_symbols(screened.reason)}",
    )


def file_table(preview: ImportPreview) -> Table:
    """Return all files: runs and reasons, values in the name, sampling."""
    rows = [_file_row(file) for file in preview.files]
    rows += [
        (printable(name), Cell(NONE, "matches no series"), "", "", "", "", NONE, NONE, NONE)
        for name in preview.unmatched
    ]
    head = (
        *("File", "Series", "Runs", "Accepted", "Reasons to reject", "In its name", "Samples"),
        *("Rate (Hz)", "Duration (s)"),
    )
    return _table(head, rows, {"File", "Series", "In its name", "Reasons to reject"}, "")


def _file_row(file: PreviewedFile) -> tuple[str | Cell, ...]:
    values = [v if v[-1:].isalpha() else f"{name} {v}" for name, v in file.fields.items()]
    return (
        printable(file.name),
        printable(file.series),
        str(len(file.runs)),
        str(file.accepted),
        f"error: {printable(file.error)}" if file.error else _codes(file),
        printable(", ".join(values)),
        str(file.samples) if file.samples else NONE,
        short(file.rate_hz),
        short(file.duration_s),
    )


def _codes(file: PreviewedFile) -> str:
    counts: dict[str, int] = defaultdict(int)
    for run in file.runs:
        for code in dict.fromkeys(r.partition(":")[0] for r in run.screened.reasons):
            counts[code.replace("_", " ")] += 1
    return ", ".join(f"{code} ({n})" for code, n in counts.items())


def _table(
    head: tuple[str, ...],
    rows: Sequence[tuple[str | Cell, ...]],
    text: set[str],
    title: str,
) -> Table:
    cells = tuple(tuple(c if isinstance(c, Cell) else Cell(c) for c in row) for row in rows)
    return Table(head, cells, frozenset(text), title=title)

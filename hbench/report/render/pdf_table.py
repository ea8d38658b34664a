"""Tables on the sheets of a PDF, in proportional letters with columns as wide as their content."""

from collections.abc import Collection, Sequence

from hbench.report.render.pdf_pen import LINE, SHEET_HEIGHT, Pen, width_of, words_of, wrapped

CELLS = 7.2  # size of letters, points
SMALLEST = 5.0  # of a table with many columns
QUIET = "#444444"
_GAP = 8.0  # between columns
_WHOLE = SHEET_HEIGHT / 10  # height up to which a table is not divided


def set_table(
    pen: Pen,
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    numbers: Collection[int],
    title: str = "",
    bold: Collection[int] = (),
) -> None:
    """Set a table over the column; its ``title`` and head are repeated on the next sheet.

    A table of up to a tenth of a sheet is not divided. ``numbers`` are the columns that are
    aligned to the right, ``bold`` the rows in bold letters. Letters become smaller, down to
    ``SMALLEST``, where the words of a row would not fit side by side.
    """
    weights = ["bold" if number in bold else "normal" for number in range(len(rows))]
    size = _size(head, rows, pen.width, weights)
    widths = _widths(head, rows, pen.width, size, weights)
    heads = _cells(head, widths, size, "bold")

    def set_head() -> None:
        _line(pen, heads, widths, numbers, size, weight="bold", color=QUIET)

    lines = [_cells(row, widths, size, weight) for row, weight in zip(rows, weights, strict=True)]

    def go_on() -> None:
        if title:
            pen.write(f"{title} (continued)", CELLS, weight="bold")
            pen.space(2)
        set_head()

    pen.room(least_height(pen, head, rows, weights))
    set_head()
    pen.on_turn = go_on
    for number, cells in enumerate(lines):
        together = lines[number:] if number == len(lines) - 2 else [cells]  # no last row alone
        pen.room(sum(_height(each, size) for each in together))
        _line(pen, cells, widths, numbers, size, weight=weights[number])
    pen.on_turn = None
    pen.space(2)


def least_height(
    pen: Pen,
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    weights: Sequence[str] | None = None,
) -> float:
    """Return the height that a table needs on its first sheet.

    It is that of the whole table up to a tenth of a sheet, or else of the head and the first two
    rows. ``weights`` are those of the rows; all of them are normal without any.
    """
    weights = weights or ["normal"] * len(rows)
    size = _size(head, rows, pen.width, weights)
    widths = _widths(head, rows, pen.width, size, weights)
    above = _height(_cells(head, widths, size, "bold"), size)
    heights = [
        _height(_cells(row, widths, size, weight), size)
        for row, weight in zip(rows, weights, strict=True)
    ]
    whole = above + sum(heights)
    return whole if whole <= _WHOLE else above + sum(heights[:2])


def _line(
    pen: Pen,
    cells: list[list[str]],
    widths: list[float],
    numbers: Collection[int],
    size: float,
    **look: str,
) -> None:
    top, left = pen.y, pen.x
    for column, (lines, width) in enumerate(zip(cells, widths, strict=True)):
        pen.y = top + 1
        right = column in numbers
        for line in lines:
            x = left + width if right else left
            pen.write(line, size, x=x, ha="right" if right else "left", **look)
        left += width + _GAP
    pen.y = top + _height(cells, size)
    pen.rule()


def _height(cells: list[list[str]], size: float) -> float:
    return max(map(len, cells)) * size * LINE + 3


def _cells(row: Sequence[str], widths: list[float], size: float, weight: str) -> list[list[str]]:
    return [wrapped(cell, width, size, weight) for cell, width in zip(row, widths, strict=True)]


def _least(
    head: Sequence[str], rows: Sequence[Sequence[str]], weights: Sequence[str]
) -> list[float]:
    """Return the width of each column's widest word, per point of the letters' size."""
    least = [max(width_of(word, "bold") for word in words_of(cell)) for cell in head]
    for row, weight in zip(rows, weights, strict=True):
        for column, cell in enumerate(row):
            widest = max(width_of(word, weight) for word in words_of(cell))
            least[column] = max(least[column], widest)
    return least


def _size(
    head: Sequence[str], rows: Sequence[Sequence[str]], width: float, weights: Sequence[str]
) -> float:
    free = width - _GAP * (len(head) - 1)
    needed = sum(_least(head, rows, weights))
    return CELLS if not needed else min(CELLS, max(SMALLEST, free / needed))


def _widths(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    width: float,
    size: float,
    weights: Sequence[str],
) -> list[float]:
    """Return widths that fill ``width``: words are not broken if possible.

    Of the space that the widest words leave, the rows get what they need before the head, and the
    columns that need least first: short cells stay on a line, long ones are wrapped.
    """
    widths = [size * each for each in _least(head, rows, weights)]
    free = width - _GAP * (len(head) - 1)
    if sum(widths) >= free:  # words longer than the page is wide are broken
        return [free * each / sum(widths) for each in widths]
    for some in (list(zip(rows, weights, strict=True)), [(head, "bold")]):
        longest = [
            max((width_of(row[c], weight) for row, weight in some), default=0.0)
            for c in range(len(head))
        ]
        wanted = [
            max(0.0, size * more - fewer) for more, fewer in zip(longest, widths, strict=True)
        ]
        spare = free - sum(widths)
        columns = sorted(range(len(widths)), key=wanted.__getitem__)
        for left, column in zip(range(len(columns), 0, -1), columns, strict=True):
            more = min(wanted[column], spare / left)
            widths[column] += more
            spare -= more
    rest = (free - sum(widths)) / len(widths)
    return [each + rest for each in widths]

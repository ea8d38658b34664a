"""Ways in which files go bad, made by a seeded generator.

A mutation is a function (generator, path) that spoils a file in place and returns words for what
it did. ``LOG``, ``JOURNAL``, ``YAML``, ``TABLE``, ``TABS`` and ``INDEX`` list them by kind of file.
"""

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from random import Random

import yaml

Mutation = Callable[[Random, Path], str]

NOT_A_VALUE = (
    *(".nan", ".inf", "-.inf", "[]", "[1, 2]", "{}", "{a: 1}", "''", "null", "true", "abc"),
    *("'nan'", "'inf bar'", "'150'", "'150 psi?'", "'150 mm V'", "'-1e9 bar'", "2026-99-99"),
    *("2026-01-01", "1e999", "!!binary aGk=", "!!int x", "!!bool maybe", '"\\0"', "9" * 5000),
    *("'1 bar^999999999'", "'1 mm^-99999'", "0x10", "[[[[1]]]]", "'=1+1'", "-1.0e+300", "1.0e+300"),
    *("!!python/object:os.system x", "'" + "1 " + " " * 3000 + "x'", "-0.001", "'$x_{$'"),
)


# ---- any file --------------------------------------------------------------------------------


def truncated(rng: Random, path: Path) -> str:
    data = path.read_bytes()
    at = rng.randrange(len(data))
    path.write_bytes(data[:at])
    return f"cut at byte {at} of {len(data)}"


def flipped(rng: Random, path: Path) -> str:
    data = bytearray(path.read_bytes())
    places = [rng.randrange(len(data)) for _ in range(rng.choice((1, 1, 1, 3, 20)))]
    for place in places:
        data[place] ^= 1 << rng.randrange(8)
    path.write_bytes(bytes(data))
    return f"bits flipped at {places}"


def typed(rng: Random, path: Path) -> str:
    """A key was hit by accident: another printable character."""
    data = bytearray(path.read_bytes())
    place = rng.randrange(len(data))
    data[place] = rng.randrange(32, 127)
    path.write_bytes(bytes(data))
    return f"byte {place} is {chr(data[place])!r}"


def nul(rng: Random, path: Path) -> str:
    data = path.read_bytes()
    at, count = rng.randrange(len(data)), rng.choice((1, 4, 512))
    path.write_bytes(data[:at] + bytes(count) + data[at + rng.choice((0, count)) :])
    return f"{count} NUL at {at}"


def crlf(rng: Random, path: Path) -> str:
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    return "CRLF"


def empty(rng: Random, path: Path) -> str:
    path.write_bytes(rng.choice((b"", b"\n", b"   ", b"\xef\xbb\xbf", b"\xff\xfe", b"\n" * 5000)))
    return "empty"


def binary(rng: Random, path: Path) -> str:
    path.write_bytes(rng.randbytes(rng.choice((1, 16, 2000, 100_000))))
    return "random bytes"


def gone(rng: Random, path: Path) -> str:
    path.unlink()
    if rng.random() < 0.5:
        path.mkdir()
        return "a folder"
    return "gone"


def absurd(rng: Random, path: Path) -> str:
    """A size that no such file has; sparse, so that it costs nothing."""
    with path.open("r+b") as file:
        file.truncate(40_000_000_000)
    return "40 GB"


def lines_changed(rng: Random, path: Path) -> str:
    lines = path.read_bytes().splitlines(keepends=True)
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    how = rng.choice(("swapped", "removed", "doubled", "moved", "shuffled", "block removed"))
    if how == "swapped":
        lines[i], lines[j] = lines[j], lines[i]
    elif how == "removed":
        del lines[i]
    elif how == "doubled":
        lines.insert(j if rng.random() < 0.5 else i, lines[i])
    elif how == "moved":
        lines.insert(j, lines.pop(i))
    elif how == "shuffled":
        part = lines[min(i, j) : max(i, j) + 1]
        rng.shuffle(part)
        lines[min(i, j) : max(i, j) + 1] = part
    else:
        del lines[min(i, j) : max(i, j) + 1]
    path.write_bytes(b"".join(lines))
    return f"lines {how}: {i + 1}, {j + 1}"


ANY = (truncated, flipped, typed, nul, crlf, empty, binary, gone, absurd, lines_changed)


# ---- raw logs --------------------------------------------------------------------------------


def words_replaced(rng: Random, path: Path) -> str:
    lines = path.read_text().split("\n")
    for _ in range(rng.choice((1, 5, 200))):
        lines[rng.randrange(1, len(lines))] = rng.choice(
            (
                f"{rng.randrange(65536):04x}",
                "ffff",
                "0000",
                "FFFF",
                "0x1234",
                "12345678",
                "zz",
                "-1",
            )
        )
    path.write_text("\n".join(lines))
    return "words replaced"


def head_replaced(rng: Random, path: Path) -> str:
    head = rng.choice(
        (
            *(
                "1651 1 0 0 ffffffff",
                "1651 1 0 0 1",
                "1651 2 0 0 0",
                "1651 3 0 0 0",
                "1651 4 0 0 0",
            ),
            *("1651 9 0 0 0", "1651 7 0 0 0", "1652 1 0 0 0", "1651 1 0 0", "1651", "", "t_s,x_m"),
            *("1651 1 0 0 -1", "1651 1 0 0 " + "f" * 5000, "1651 1 0 0 0 0 0 0", "nan", "\x0c"),
        )
    )
    _, _, rest = path.read_text().partition("\n")
    path.write_text(f"{head}\n{rest}")
    return f"head {head[:30]!r}"


def one_long_line(rng: Random, path: Path) -> str:
    path.write_text(path.read_text().replace("\n", rng.choice(("", " ", ","))))
    return "one line"


LOG = (*ANY, words_replaced, head_replaced, one_long_line)


# ---- YAML ------------------------------------------------------------------------------------


def leaves(value, path=()):
    """Yield the path and the value of each scalar."""
    if isinstance(value, dict | list):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield from leaves(item, (*path, key))
    else:
        yield path, value


def parent(content, path):
    """Return the section in which a path ends."""
    for key in path[:-1]:
        content = content[key]
    return content


def _rewritten(path: Path, content, **marks: str) -> None:
    """Write YAML; where a value is a mark, its text stands there as it is."""
    text = yaml.dump(content, Dumper=yaml.CSafeDumper, sort_keys=False, width=10**9)
    for mark, value in marks.items():
        text = text.replace(mark, value)
    path.write_text(text)


def value_replaced(rng: Random, path: Path) -> str:
    content = yaml.safe_load(path.read_text())
    where, old = rng.choice(list(leaves(content)))
    parent(content, where)[where[-1]] = "MARKED"
    new = rng.choice(NOT_A_VALUE)
    _rewritten(path, content, MARKED=new)
    return f"{where}: {str(old)[:20]} -> {new[:30]}"


def section_replaced(rng: Random, path: Path) -> str:
    content = yaml.safe_load(path.read_text())
    where, _ = rng.choice(list(leaves(content)))
    where = where[: rng.randrange(1, len(where) + 1)]
    parent(content, where)[where[-1]] = "MARKED"
    new = rng.choice(NOT_A_VALUE)
    _rewritten(path, content, MARKED=new)
    return f"{where} -> {new[:30]}"


def key_removed(rng: Random, path: Path) -> str:
    content = yaml.safe_load(path.read_text())
    where, _ = rng.choice(list(leaves(content)))
    where = where[: rng.randrange(1, len(where) + 1)]
    del parent(content, where)[where[-1]]
    _rewritten(path, content)
    return f"{where} removed"


def key_renamed(rng: Random, path: Path) -> str:
    content = yaml.safe_load(path.read_text())
    where, old = rng.choice([leaf for leaf in leaves(content) if isinstance(leaf[0][-1], str)])
    del parent(content, where)[where[-1]]
    parent(content, where)["MARKED"] = old
    new = rng.choice(("x", "1", "[a]", "''", ".nan", "null", "{a: b}", "<<", "=", "2026-99-99"))
    _rewritten(path, content, MARKED=new)
    return f"{where} -> key {new}"


def unit_replaced(rng: Random, path: Path) -> str:
    content = yaml.safe_load(path.read_text())
    quantities = [
        (where, value)
        for where, value in leaves(content)
        if isinstance(value, str) and re.fullmatch(r"-?[\d.]+(e-?\d+)? [A-Za-z].*", value)
    ]
    where, value = rng.choice(quantities)
    number = value.split()[0]
    unit = rng.choice(("", "V/(Pa s)^2", "K", "psi?", "mmm", "bar bar", "(", "^2", "1/", "m^", "€"))
    parent(content, where)[where[-1]] = f"{number} {unit}".strip()
    _rewritten(path, content)
    return f"{where}: {value} -> {number} {unit}"


def aliases(rng: Random, path: Path) -> str:
    """A billion laughs, or a section that holds itself."""
    content = yaml.safe_load(path.read_text())
    where, _ = rng.choice(list(leaves(content)))
    where = where[: rng.randrange(1, len(where) + 1)]
    key = where[-1]
    parent(content, where)[key] = "MARKED"
    if rng.random() < 0.3:
        _rewritten(path, content, MARKED="&a [*a]")
        return f"{where} holds itself"
    bomb = [f"&a0 [{', '.join('x' * 9)}]"]
    bomb += [f"&a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, rng.choice((3, 12)))]
    _rewritten(path, content, MARKED=f"[{', '.join(bomb)}]")
    return f"{where} -> aliases"


def nested(rng: Random, path: Path) -> str:
    content = yaml.safe_load(path.read_text())
    where, _ = rng.choice(list(leaves(content)))
    where = where[: rng.randrange(1, len(where) + 1)]
    parent(content, where)[where[-1]] = "MARKED"
    n = rng.choice((100, 3000, 200_000))
    _rewritten(path, content, MARKED="[" * n + "]" * n)
    return f"{where} nested {n} deep"


YAML = (
    *(*ANY, value_replaced, value_replaced, value_replaced, section_replaced, key_removed),
    *(key_renamed, unit_replaced, aliases, nested),
)


def run_id_replaced(rng: Random, path: Path) -> str:
    text = path.read_text()
    ids = re.findall(r"^- run: (.+)$", text, re.M)
    old = rng.choice(ids)
    new = rng.choice((*ids, "../x", "/etc/passwd", "''", "5", ".nan", "[1]", "'a/b'", "'CON'", "~"))
    path.write_text(text.replace(f"- run: {old}\n", f"- run: {new}\n"))
    return f"run {old} -> {new}"


def run_again(rng: Random, path: Path) -> str:
    """A run stands there twice, maybe with the plan or the end of another one."""
    text = path.read_text()
    runs = re.findall(r"^- run:.*\n(?:  .*\n)+", text, re.M)
    one, other = rng.choice(runs), rng.choice(runs)
    lines, others = one.splitlines(keepends=True), other.splitlines(keepends=True)
    part = rng.randrange(1, min(len(lines), len(others)))
    if rng.random() < 0.7:
        lines[part] = others[part]
    path.write_text(text + "".join(lines))
    return "a run again"


JOURNAL = (*YAML, run_id_replaced, run_again)


# ---- delimited text --------------------------------------------------------------------------


def _cells(path: Path, separator: str) -> list[list[str]]:
    return [line.split(separator) for line in path.read_text().splitlines()]


def _put(path: Path, rows: list[list[str]], separator: str) -> None:
    path.write_text("\n".join(separator.join(row) for row in rows) + "\n")


def cell_replaced(rng: Random, path: Path, separator: str = ",") -> str:
    rows = _cells(path, separator)
    row = rng.randrange(len(rows))
    column = rng.randrange(len(rows[row]))
    new = rng.choice(
        (
            *(
                "",
                "nan",
                "NaN",
                "inf",
                "-inf",
                "1e300",
                "-1e300",
                "1e999",
                "5.2 bar",
                '"',
                '"1"',
                "x",
            ),
            *("1_0", "0x10", "1,5", "'", "=1", "\x00", "9" * 5000, "²", "1e", "--", "../x", "NA"),
        )
    )
    old, rows[row][column] = rows[row][column], new
    _put(path, rows, separator)
    return f"row {row + 1}, column {column + 1}: {old[:20]} -> {new[:20]!r}"


def column_emptied(rng: Random, path: Path, separator: str = ",") -> str:
    rows = _cells(path, separator)
    column, value = rng.randrange(len(rows[0])), rng.choice(("", "nan", "inf", "x", "1e300"))
    for row in rows[1:]:
        row[column] = value
    _put(path, rows, separator)
    return f"column {column + 1} is {value!r}"


def column_removed(rng: Random, path: Path, separator: str = ",") -> str:
    rows = _cells(path, separator)
    column = rng.randrange(len(rows[0]))
    for row in rows:
        del row[column]
    _put(path, rows, separator)
    return f"column {column + 1} removed"


def column_doubled(rng: Random, path: Path, separator: str = ",") -> str:
    """The same name twice; the second one holds other values."""
    rows = _cells(path, separator)
    column, other = rng.randrange(len(rows[0])), rng.randrange(len(rows[0]))
    for number, row in enumerate(rows):
        row.append(row[other if number else column])
    _put(path, rows, separator)
    return f"column {column + 1} twice"


def reversed_rows(rng: Random, path: Path, separator: str = ",") -> str:
    head, *rows = path.read_text().splitlines()
    path.write_text("\n".join([head, *rows[::-1]]) + "\n")
    return "rows reversed"


def separators(rng: Random, path: Path, separator: str = ",") -> str:
    new = rng.choice((";", "\t", " ", "|", ",,", ""))
    path.write_text(path.read_text().replace(separator, new))
    return f"separator {new!r}"


def few_rows(rng: Random, path: Path, separator: str = ",") -> str:
    lines, count = path.read_text().splitlines(), rng.choice((1, 2, 3))
    path.write_text("\n".join(lines[:count]) + "\n")
    return f"{count} lines"


def many_columns(rng: Random, path: Path, separator: str = ",") -> str:
    rows, count = _cells(path, separator)[:3], 20_000
    _put(path, [[*row, *(f"{n}" for n in range(count))] for row in rows], separator)
    return f"{count} columns"


def open_quote(rng: Random, path: Path, separator: str = ",") -> str:
    text = path.read_text()
    at = rng.randrange(len(text))
    text = text[:at] + '"' + text[at:] + rng.choice(("", "1," * 100_000))
    path.write_text(text)
    return f"quote at {at}"


def _tables(separator: str) -> tuple[Mutation, ...]:
    named = (cell_replaced, cell_replaced, cell_replaced, column_emptied, column_removed)
    named += (column_doubled, reversed_rows, separators, few_rows, many_columns, open_quote)
    return (*ANY, *(partial(one, separator=separator) for one in named))


TABLE, TABS = _tables(","), _tables("\t")


def index_cell(rng: Random, path: Path) -> str:
    """Ids and paths that must not be followed; loads and speeds that are none."""
    rows = _cells(path, ",")
    row, column = rng.randrange(1, len(rows)), rng.randrange(len(rows[0]))
    new = rng.choice(
        (
            *(rows[rng.randrange(1, len(rows))][column], "../x", "/etc/passwd", "..", "runs", "."),
            *(
                "a" * 5000,
                "a\x00b",
                "nan",
                "inf",
                "-1",
                "0",
                "1e300",
                "9" * 400,
                "\\\\host\\x",
                "NUL",
            ),
        )
    )
    rows[row][column] = new
    _put(path, rows, ",")
    return f"row {row + 1}: {rows[0][column]} = {new[:20]!r}"


INDEX = (*TABLE, *(index_cell,) * 4)


def name_of(mutation: Mutation) -> str:
    return mutation.func.__name__ if isinstance(mutation, partial) else mutation.__name__

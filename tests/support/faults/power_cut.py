"""System calls of this process below a folder, and what a power cut leaves of each prefix of them.

``Trace`` records the calls. ``Disk`` is a model of a file system after ALICE (Pillai et al., 2014)
and POSIX: written octets are durable once their file was flushed, entries of a folder once the
folder was. ``leftovers`` gives the trees that a cut may leave:

- ``flushed``: nothing but what was flushed
- ``names first``: all entries of folders, but only flushed octets; a file may be empty
- ``torn``: the same, with half of the octets that were not flushed
- ``killed``: everything, as after the end of the process alone
"""

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pytest

Tree = dict[str, bytes | None]  # octets by path; None: a folder
KINDS = ("flushed", "names first", "torn", "killed")


@dataclass(frozen=True)
class Call:
    """A system call: its name, its paths below the folder, and what it writes where."""

    name: str
    path: str
    other: str = ""
    at: int = 0
    data: bytes = b""


class Trace:
    """The calls below ``root``, in order."""

    def __init__(self, root: Path):
        self._root = os.path.realpath(root)
        self.calls: list[Call] = []

    def note(self, name: str, path, other="", at: int = 0, data: bytes = b"") -> None:
        """Keep a call, if it is below the folder."""
        inside = self._inside(path)
        if inside is not None:
            to = (self._inside(other) or "") if other else ""
            self.calls.append(Call(name, inside, to, at, data))

    def _inside(self, path) -> str | None:
        path = os.path.abspath(os.fsdecode(path))
        if path != self._root and not path.startswith(self._root + os.sep):
            return None
        return os.path.relpath(path, self._root)

    @contextmanager
    def recording(self) -> Iterator[None]:
        """Record what happens in here."""
        really_open, note = io.open, self.note

        class File(io.FileIO):
            """A file that is written without a buffer between it and the trace."""

            def write(self, data):
                note("write", self.name, at=self._end(), data=bytes(data))
                return super().write(data)

            def truncate(self, size=None):
                note("truncate", self.name, at=self.tell() if size is None else size)
                return super().truncate(size)

            def _end(self):
                return os.fstat(self.fileno()).st_size if "a" in self.mode else self.tell()

        def traced_open(file, mode="r", *arguments, **options):
            if "b" not in mode or mode == "rb" or self._inside(file) is None:
                assert mode[0] == "r" or self._inside(file) is None, f"{file}: written as text"
                return really_open(file, mode, *arguments, **options)
            existed = os.path.exists(file)
            raw = File(os.fspath(file), mode.replace("b", ""))
            if not existed:
                note("create", file)
            elif "w" in mode:
                note("truncate", file)
            return io.BufferedRandom(raw) if "+" in mode else io.BufferedWriter(raw)

        def traced(name):
            really = getattr(os, name)

            def call(path, *arguments, **options):
                result = really(path, *arguments, **options)
                note(name, path, *arguments[:1] if name in ("replace", "rename") else ())
                return result

            return call

        def traced_truncate(path, length):
            really_truncate(path, length)
            note("truncate", path, at=length)

        really_truncate = os.truncate
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(io, "open", traced_open)
            for name in ("replace", "rename", "mkdir", "rmdir", "unlink"):
                patch.setattr(os, name, traced(name))
            patch.setattr(os, "truncate", traced_truncate)
            patch.setattr(os, "fsync", lambda fd: note("fsync", os.readlink(f"/proc/self/fd/{fd}")))
            yield


@dataclass
class Node:
    """A file's octets or a folder's entries, and what of them is durable."""

    now: bytes | dict
    durable: bytes | dict = field(default_factory=bytes)


class Disk:
    """A folder's file system, to which calls are applied."""

    def __init__(self, tree: Tree):
        self._root = Node({}, {})
        for path, data in sorted(tree.items()):  # folders before what is in them
            self._entries(path)[os.path.basename(path)] = Node(
                {} if data is None else data, {} if data is None else data
            )
        self._flush_all(self._root)

    def apply(self, call: Call) -> None:
        """Do one call."""
        name = os.path.basename(call.path)
        if call.name == "mkdir":
            self._entries(call.path)[name] = Node({}, {})
        elif call.name == "create":
            self._entries(call.path)[name] = Node(b"")
        elif call.name in ("unlink", "rmdir"):
            del self._entries(call.path)[name]
        elif call.name in ("replace", "rename"):
            node = self._entries(call.path).pop(name)
            self._entries(call.other)[os.path.basename(call.other)] = node
        else:
            node = self._node(call.path)
            if call.name == "write":
                node.now = node.now[: call.at] + call.data + node.now[call.at + len(call.data) :]
            elif call.name == "truncate":
                node.now = node.now[: call.at]
            else:
                assert call.name == "fsync", call
                node.durable = dict(node.now) if isinstance(node.now, dict) else node.now

    def tree(self, kind: str) -> Tree:
        """Return what a power cut leaves."""
        found: Tree = {}
        self._collect(self._root, "", kind, found)
        return found

    def _collect(self, node: Node, path: str, kind: str, found: Tree) -> None:
        for name, below in (node.durable if kind == "flushed" else node.now).items():
            whole = os.path.join(path, name)
            if isinstance(below.now, dict):
                found[whole] = None
                self._collect(below, whole, kind, found)
            else:
                found[whole] = _octets(below, kind)

    def _node(self, path: str) -> Node:
        node = self._root
        for part in Path(path).parts:
            node = node.now[part]
        return node

    def _entries(self, path: str) -> dict:
        return self._node(os.path.dirname(path)).now

    def _flush_all(self, node: Node) -> None:
        if isinstance(node.now, dict):
            node.durable = dict(node.now)
            for below in node.now.values():
                self._flush_all(below)


def _octets(node: Node, kind: str) -> bytes:
    if kind == "killed":
        return node.now
    if kind == "torn" and node.now.startswith(node.durable):
        return node.now[: (len(node.durable) + len(node.now)) // 2]
    return node.durable


def leftovers(before: Tree, calls: list[Call]) -> list[tuple[int, str, Tree]]:
    """Return each different tree that a cut may leave: calls made, kind, tree.

    Of equal trees the last is returned, after which the most must have been kept.
    """
    disk, last = Disk(before), {}
    for made in range(len(calls) + 1):
        if made:
            disk.apply(calls[made - 1])
        for kind in reversed(KINDS):
            tree = disk.tree(kind)
            last[frozenset(tree.items())] = (made, kind, tree)
    return sorted(last.values(), key=lambda cut: (cut[0], KINDS.index(cut[1])))


def write_tree(folder: Path, tree: Tree) -> None:
    """Make a folder of a tree."""
    folder.mkdir()
    for path, data in sorted(tree.items()):
        if data is None:
            (folder / path).mkdir()
        else:
            (folder / path).write_bytes(data)

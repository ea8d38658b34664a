"""Upper bound of a program's stack, from GCC's call graphs (``-fcallgraph-info=su``)."""

import re
from pathlib import Path

_NODE = re.compile(r'^node: \{ title: "([^"]+)" label: "[^"]*?\\n(\d+) bytes \((\w+)\)"', re.M)
_EDGE = re.compile(r'^edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"', re.M)
_INDIRECT = "__indirect_call"


class CallGraph:
    """The functions of a program, their frames [octets] and calls.

    ``indirect`` names the functions that any call through a pointer may reach. Calls that the
    compiler adds itself, of memcpy and memset, count at the end of each path.
    """

    def __init__(self, folder: Path, indirect: tuple[str, ...]):
        self._frame, self._calls = {}, {}
        for path in sorted(folder.rglob("*.ci")):
            text = path.read_text()
            for title, octets, kind in _NODE.findall(text):
                assert kind == "static", f"{title}: frame of variable size"
                self._frame[title] = max(int(octets), self._frame.get(title, 0))
            for source, target in _EDGE.findall(text):
                targets = indirect if target == _INDIRECT else (target,)
                self._calls.setdefault(source, set()).update(targets)
        self._added = max(self._frame["memcpy"], self._frame["memset"])

    def depth(self, function: str, path: tuple[str, ...] = ()) -> int:
        """Most octets of stack that a function and all that it calls use.

        A static function's title begins with its file: ``.../board.c:mask_control``.
        """
        titles = [title for title in self._frame if title.endswith(f":{function}")]
        (title,) = [function] if function in self._frame else titles
        assert title not in path, f"{title}: recursive"
        calls = self._calls.get(title, ())
        deepest = max((self.depth(name, (*path, title)) for name in calls), default=self._added)
        return self._frame[title] + deepest

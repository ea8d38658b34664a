"""Generates the C header of the message dictionary.

``python -m hbench.protocol.header > firmware/core/dictionary.h``
"""

from collections.abc import Iterable

from hbench.protocol import dictionary as d


def header_text() -> str:
    """The text of ``firmware/core/dictionary.h``."""
    blocks = [
        "/* Generated from hbench/protocol/dictionary.py by hbench.protocol.header: do not edit. */",
        "#ifndef HB_DICTIONARY_H\n#define HB_DICTIONARY_H",
        _defines(
            ("HB_PROTOCOL", f"{d.PROTOCOL}u"),
            ("HB_DICTIONARY_HASH", f"0x{d.dictionary_hash():08X}UL"),
            ("HB_REPLY", f"0x{d.REPLY:02X}u"),
            ("HB_ERROR", f"0x{d.ERROR:02X}u"),
            ("HB_MAX_FRAME", f"{d.MAX_FRAME}u"),
            ("HB_CRC_START", f"0x{d.CRC_START:04X}u"),
        ),
        _enum("message", ((message.name, message.code) for message in d.MESSAGES)),
        _numbered("state", d.STATES),
        _numbered("phase", d.PHASES),
        _numbered("kind", d.KINDS, count="HB_KINDS"),
        _numbered("fault", d.FAULTS),
        _numbered("refusal", d.REFUSALS),
        _numbered("sensor", d.SENSORS, count="HB_SENSORS"),
        _numbered("setting", d.SETTINGS, count="HB_SETTINGS"),
        _numbered("word", (word.name for word in d.RECORD), count="HB_RECORD_WORDS"),
        "/* Words per SI unit, the inverse of the dictionary's scales. */\n"
        + _defines(
            *(
                (f"HB_WORD_{word.name.upper()}_PER_SI", f"{1 / word.scale:.1f}f")
                for word in _scaled()
            )
        ),
        _enum("flag", ((name, 1 << bit) for bit, name in enumerate(d.FLAGS))),
        "#endif",
    ]
    return "\n\n".join(blocks) + "\n"


def _scaled() -> Iterable[d.Word]:
    return (word for word in d.RECORD if word.unit not in ("1", "count"))


def _defines(*pairs: tuple[str, str]) -> str:
    return "\n".join(f"#define {name} {value}" for name, value in pairs)


def _enum(kind: str, members: Iterable[tuple[str, int]], count: str = "") -> str:
    rows = [f"    HB_{kind.upper()}_{name.upper()} = {value}" for name, value in members]
    if count:
        rows.append(f"    {count} = {len(rows)}")
    return f"enum hb_{kind} {{\n" + ",\n".join(rows) + "\n};"


def _numbered(kind: str, names: Iterable[str], count: str = "") -> str:
    return _enum(kind, ((name, number) for number, name in enumerate(names)), count)


if __name__ == "__main__":
    print(header_text(), end="")

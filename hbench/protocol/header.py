"""C header of the message dictionary: codes, names and scales."""

from collections.abc import Iterable

from hbench.protocol import dictionary as d
from hbench.protocol.payloads import NOTICE


def header_text() -> str:
    """Return the text of ``firmware/core/dictionary.h``."""
    blocks = [
        NOTICE,
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
        _numbered("valves", d.VALVES, count="HB_VALVES_STATES"),
        _numbered("load_control", d.LOAD_CONTROLS, count="HB_LOAD_CONTROLS"),
        _numbered("condition", d.CONDITIONS, count="HB_CONDITIONS"),
        _numbered("fault", d.FAULTS),
        _numbered("refusal", d.REFUSALS),
        _numbered("sensor", d.SENSORS, count="HB_SENSORS"),
        "/* Converter words of a tick: the sensors, then the auxiliary input. */\n"
        + _defines(
            ("HB_INPUT_AUXILIARY", f"{d.INPUTS.index('auxiliary')}u"),
            ("HB_INPUTS", f"{len(d.INPUTS)}u"),
        ),
        _numbered("setting", d.SETTINGS, count="HB_SETTINGS"),
        "/* Lowest and highest value of each setting. */\n"
        + _defines(("HB_SETTING_RANGES", _rows(map(_range, d.SETTING_RANGES.values())))),
        _numbered("word", (word.name for word in d.RECORD), count="HB_RECORD_WORDS"),
        "/* Words per SI unit, the inverse of the dictionary's scales. */\n"
        + _defines(*((f"HB_WORD_{name}_PER_SI", f"{per_si:.1f}f") for name, per_si in _scaled())),
        _enum("flag", ((name, 1 << bit) for bit, name in enumerate(d.RECORD_FLAGS))),
        "/* For the status line at a terminal; the names initialise char[][HB_NAME_SIZE]. */\n"
        + _defines(
            ("HB_VERSION_TEXT", f'"protocol {d.PROTOCOL}, dictionary {d.dictionary_hash():08X}"'),
            ("HB_NAME_SIZE", f"{max(map(len, d.STATES + d.FAULTS)) + 1}u"),
            ("HB_STATE_NAMES", _texts(d.STATES)),
            ("HB_FAULT_NAMES", _texts(d.FAULTS)),
        ),
        "#endif",
    ]
    return "\n\n".join(blocks) + "\n"


def _scaled() -> Iterable[tuple[str, float]]:
    return ((w.name.upper(), 1 / w.scale) for w in d.RECORD if w.unit not in ("1", "count"))


def _defines(*pairs: tuple[str, str]) -> str:
    return "\n".join(f"#define {name} {value}" for name, value in pairs)


def _texts(names: Iterable[str]) -> str:
    return _rows(f'"{name.replace("_", " ")}"' for name in names)


def _range(limits: tuple[float, float]) -> str:
    low, high = (f"{limit!r}f" for limit in limits)
    return f"{{{low}, {high}}}"


def _rows(items: Iterable[str]) -> str:
    """Return a C initialiser, one item per line."""
    rows = ", \\\n    ".join(items)
    return f"{{ \\\n    {rows} \\\n}}"


def _enum(kind: str, members: Iterable[tuple[str, int]], count: str = "") -> str:
    rows = [f"    HB_{kind.upper()}_{name.upper()} = {value}" for name, value in members]
    if count:
        rows.append(f"    {count} = {len(rows)}")
    return f"enum hb_{kind} {{\n" + ",\n".join(rows) + "\n};"


def _numbered(kind: str, names: Iterable[str], count: str = "") -> str:
    return _enum(kind, ((name, number) for number, name in enumerate(names)), count)

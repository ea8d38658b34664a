"""Text from the bytes of a file: its encoding, and plain marks in its numbers."""

import codecs
import re
from contextlib import suppress

_BOMS = {  # those of UTF-32 first: the one of UTF-16 is a part of it
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF32_LE: "utf-32",
    codecs.BOM_UTF32_BE: "utf-32",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
_NARROW_SPACE = re.compile(r"(?<=[0-9])[\u00a0\u2009\u202f](?=[0-9]{3})")
_APOSTROPHE = re.compile(r"(?<=[0-9])\u2019(?=[0-9]{3})")
_MINUS = re.compile(r"\u2212(?=[0-9.,])")
_KANA = re.compile("[ぁ-ヶ]{2}")  # two in a row
_NO_TEXT = re.compile("[\0-\b\x0e-\x1f\ufffd\uffff]")
_HEAD, _MOST_CONTROLS = 2000, 0.05  # characters, and the largest share of controls in a text
_ABOVE_ASCII = re.compile(rb"[\x80-\xff]+")


def decoded(data: bytes) -> str:
    """Return the text, with plain marks in its numbers.

    Narrow and unbreakable spaces between digits become spaces, typographic apostrophes and minus
    signs plain ones.
    """
    text = _decoded(data)
    if text.isascii():
        return text
    text = _NARROW_SPACE.sub(" ", text)
    return _APOSTROPHE.sub("'", _MINUS.sub("-", text))


def is_text(text: str) -> bool:
    """Return whether decoded bytes were a text: few of its first characters are controls.

    Quotes are left out first: the result for a table is the same with and without them.
    """
    head = text[:_HEAD].replace('"', "").rstrip("\0")  # zeros: of a logger without power
    return len(_NO_TEXT.findall(head)) <= _MOST_CONTROLS * len(head)


def _decoded(data: bytes) -> str:
    """Return the text; byte-order mark, zero bytes or UTF-8 faults determine its encoding.

    Text that is not UTF-8 is Japanese (Windows code page 932) if it contains kana in that encoding,
    Chinese (GB 18030) if its bytes above 127 come in pairs, two of them in a row at least once, and
    else that of Western Europe.
    """
    for mark, name in _BOMS.items():
        if data.startswith(mark):
            return data.decode(name, errors="replace")
    if data[1:200:2].count(0) > 50 or (len(data) > 3 and data[1] == data[3] == 0):
        return data.decode("utf-16-le", errors="replace")
    if data[0:200:2].count(0) > 50 or (len(data) > 3 and data[0] == data[2] == 0):
        return data.decode("utf-16-be", errors="replace")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        with suppress(UnicodeDecodeError):
            if _KANA.search(japanese := data.decode("cp932")):
                return japanese
        lengths = [len(part) for part in _ABOVE_ASCII.findall(data)]
        if max(lengths) >= 4 and not any(length % 2 for length in lengths):
            with suppress(UnicodeDecodeError):
                return data.decode("gb18030")
        return data.decode("cp1252", errors="replace")

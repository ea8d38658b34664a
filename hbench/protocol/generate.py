"""Writes the firmware's C files that follow from the message dictionary.

``python -m hbench.protocol.generate`` in the repository's root renews ``firmware/core``.
"""

from pathlib import Path

from hbench.protocol.header import header_text
from hbench.protocol.payloads import payloads_header, payloads_source

FOLDER = Path("firmware/core")


def generated_files() -> dict[str, str]:
    """Return the text of each generated file by name."""
    return {
        "dictionary.h": header_text(),
        "payloads.h": payloads_header(),
        "payloads.c": payloads_source(),
    }


if __name__ == "__main__":
    for name, text in generated_files().items():
        (FOLDER / name).write_text(text)

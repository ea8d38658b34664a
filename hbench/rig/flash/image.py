"""Firmware images: ELF for the STM32F4, the text of hex2000 for the F28335."""

from pathlib import Path

from hbench.config.files.regular_file import FileTooLarge, read_regular_file
from hbench.errors import ConfigError, DataError
from hbench.rig.flash.f28335.boot_image import BootImage, parse_boot_image
from hbench.rig.flash.stm32f4.elf_image import MAGIC, ElfImage, parse_elf_image

_LARGEST = 16_000_000  # bytes; what a chip takes is a tenth of that
Image = BootImage | ElfImage


def read_image(path: Path) -> Image:
    """Read and check an image file. Raises ``ConfigError`` (no file), ``DataError``."""
    try:
        content = read_regular_file(path, _LARGEST)
    except FileTooLarge as error:
        raise DataError(f"{path}: {error}", "Give a firmware image.") from None
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror or error}", "Check the path.") from None
    if content.startswith(MAGIC):
        return parse_elf_image(content, str(path))
    return parse_boot_image(content.decode("latin-1"), str(path))  # decoding never fails

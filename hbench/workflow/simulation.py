"""The model alone: phenomena of friction and of the bench."""

from pathlib import Path

from hbench.config.loading import read_yaml
from hbench.errors import ConfigError
from hbench.records import Phenomenon
from hbench.report.draw_phenomena import draw_phenomenon
from hbench.report.figures import figure_files
from hbench.report.phenomenon_page import phenomenon_page
from hbench.store.atomic import write_files


def phenomena() -> tuple[str, ...]:
    """Return the names of what ``simulate`` knows."""
    from hbench.experiment.phenomena import PHENOMENA  # compiles

    return tuple(PHENOMENA)


def simulate(name: str, bench_file: Path) -> Phenomenon:
    """Simulate a phenomenon by its name, on a bench where it needs one.

    Raises ``ConfigError``.
    """
    from hbench.experiment.phenomena import PHENOMENA

    if name not in PHENOMENA:
        raise ConfigError(f"unknown phenomenon {name!r}", f"There are: {', '.join(PHENOMENA)}.")
    return PHENOMENA[name](read_yaml(bench_file))


def write_phenomenon(folder: Path, phenomenon: Phenomenon) -> None:
    """Write a phenomenon's page, its figures, and the data of each as CSV."""
    drawings = draw_phenomenon(phenomenon)
    page = phenomenon_page(phenomenon, drawings)
    files = figure_files(drawings) | {f"{phenomenon.name}.html": page.encode()}
    write_files(folder, files)

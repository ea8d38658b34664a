"""Import of another bench's logs, and the suggestion of an import map."""

from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from hbench.experiment.campaign_header import software
from hbench.store.importing.importer import ImportSummary, import_folder
from hbench.store.suggesting.suggest import Suggestion, suggest_map


def import_runs(
    source: Path, folder: Path, map_file: Path | None, clock: Callable[[], datetime]
) -> ImportSummary:
    """Import another bench's logs as a campaign. Raises ``ConfigError``, ``DataError``."""
    return import_folder(source, folder, map_file, software(), clock())


def suggest_import_map(source: Path) -> Suggestion:
    """Suggest a map for the logs in ``source``. Raises ``ConfigError``, ``DataError``."""
    return suggest_map(source)

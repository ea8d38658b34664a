"""Makes the example documents anew: ``python data_samples/documents.py`` (simulated; five minutes).

Writes ``report.png`` and the folder ``documents``. Needs Chromium for the pictures of pages. The
fleet's cylinders differ in the Coulomb friction of their plants, drawn with a fixed seed; from the
eleventh cylinder on it is 25 N higher.
"""

import io
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr
from datetime import UTC, date, datetime, timedelta
from pathlib import Path

import numpy as np
import yaml
from PIL import Image

from hbench import workflow
from hbench.cli.watch_server import new_server
from hbench.report.conformity.text import acceptance_text

HERE = Path(__file__).parent
CONFIGS = HERE.parent / "configs"
DOCUMENTS = HERE / "documents"
CYLINDERS = 14
WIDTH = 1160  # of a page's picture, pixels
COLOURS = 96
START = datetime(2026, 1, 5, 8, 0, tzinfo=UTC)
LIMITS = {
    "product": "sample cylinder",
    "rule": "guard_band",
    "limits": [
        {"quantity": "friction", "load": "1000 N", "speed": "85 mm/s", "max": "780 N"},
        {"quantity": "efficiency", "load": "5000 N", "speed": "85 mm/s", "min": "80 %"},
    ],
}


def main() -> None:
    """Make all documents."""
    shutil.rmtree(DOCUMENTS, ignore_errors=True)
    DOCUMENTS.mkdir()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        report(folder)
        diagnosis(folder)
        acceptance_and_certificate(folder)
        fleet_station_and_comparison(folder)
        design(folder)
        identification(folder)


def report(folder: Path) -> None:
    """Picture the first page of the demo's report, and write the PDF of a smaller campaign."""
    measure(CONFIGS / "demo.yaml", folder / "demo", START)
    workflow.report(folder / "demo")
    shutil.copytree(HERE / "stribeck-small", folder / "stribeck-small")
    workflow.report(folder / "stribeck-small", form="pdf")
    shutil.copy(folder / "stribeck-small" / "results" / "report.pdf", DOCUMENTS)
    picture(folder / "demo" / "results" / "report.html", HERE / "report.png", height=1440)


def diagnosis(folder: Path) -> None:
    """Picture the page of a hidden leak that was found."""
    campaign, model = HERE / "blind" / "internal_leakage-clear-1", CONFIGS / "bench-aau.yaml"
    found = workflow.reconcile(campaign, model, lambda done, total: None)
    workflow.write_diagnosis(folder / "diagnosis", found)
    picture(folder / "diagnosis" / "report.html", DOCUMENTS / "diagnosis.png", height=1550)


def acceptance_and_certificate(folder: Path) -> None:
    """Write the decisions on an acceptance test, and its certificate."""
    campaign = folder / "HC-0007"
    measure(CONFIGS / "acceptance-test.yaml", campaign, START, serial="HC-0007")
    acceptance = workflow.accept(campaign, CONFIGS / "acceptance-limits.yaml")
    for name in ("acceptance.json", "acceptance.xml"):
        shutil.copy(campaign / "results" / name, DOCUMENTS / name)
    (DOCUMENTS / "acceptance.txt").write_text(acceptance_text(acceptance) + "\n")
    content = yaml.safe_load((CONFIGS / "certificate.yaml").read_text())
    content["specimen"]["serial"] = "HC-0007"
    content["limits"] = str(CONFIGS / "acceptance-limits.yaml")
    content["issued"] = date(2026, 1, 6)
    file = folder / "certificate.yaml"
    file.write_text(yaml.safe_dump(content, allow_unicode=True))
    for suffix in ("pdf", "xml"):
        with redirect_stderr(io.StringIO()):
            workflow.certify(campaign, file, DOCUMENTS / f"certificate.{suffix}")


def fleet_station_and_comparison(folder: Path) -> None:
    """Picture the pages of a fleet, of its station, and of two of its cylinders."""
    rng = np.random.default_rng(1)
    limits = folder / "limits.yaml"
    limits.write_text(yaml.safe_dump(LIMITS))
    plant = yaml.safe_load((HERE / "plant.yaml").read_text())
    line = folder / "line"
    for number in range(CYLINDERS):
        coulomb = 310 + 6 * rng.standard_normal() + 25 * (number >= 10)
        plant["friction"]["test"]["coulomb"] = f"{coulomb:.1f} N"
        (folder / "plant.yaml").write_text(yaml.safe_dump(plant))
        serial = f"HC-{number + 1:04d}"
        start = START + timedelta(days=number)
        made = dict(plant=folder / "plant.yaml", seed=number + 1, serial=serial)
        measure(HERE / "stribeck-small.yaml", line / serial, start, **made)
        workflow.accept(line / serial, limits)
    fleet = workflow.analyze_fleet(
        [str(line)],
        folder / "fleet",
        scheduler=None,
        speed_m_s=None,
        limits=limits,
        report=lambda *_: None,
        note=lambda _: None,
    )
    workflow.write_fleet(folder / "fleet", fleet)
    picture(folder / "fleet" / "fleet.html", DOCUMENTS / "fleet.png", height=1432)
    with served(line) as address:
        picture(address, DOCUMENTS / "station.png", height=1100)
    comparison = workflow.compare(line / "HC-0001", line / f"HC-{CYLINDERS:04d}")
    workflow.write_comparison(folder / "comparison", comparison)
    picture(folder / "comparison" / "comparison.html", DOCUMENTS / "comparison.png", height=1400)


def design(folder: Path) -> None:
    """Picture the page of the control loops' design."""
    command = ("design", CONFIGS / "bench-aau.yaml", "-o", folder / "design")
    subprocess.run(
        [sys.executable, "-m", "hbench", *map(str, command)], check=True, stdout=subprocess.DEVNULL
    )
    picture(folder / "design" / "design.html", DOCUMENTS / "design.png", height=1450)


def identification(folder: Path) -> None:
    """Picture the page of the identified friction laws."""
    measure(CONFIGS / "dynamics.yaml", folder / "dynamics", START)
    found = workflow.identify(folder / "dynamics", lambda progress: None)
    workflow.write_identification(folder / "laws", found)
    picture(folder / "laws" / "identification.html", DOCUMENTS / "identification.png", height=1390)


def measure(
    schedule: Path,
    folder: Path,
    start: datetime,
    plant: Path | None = None,
    seed: int = 1,
    serial: str | None = None,
) -> None:
    """Make a schedule's runs on the virtual rig."""
    workflow.measure(
        workflow.load_experiment(schedule, None, serial),
        folder,
        workflow.Line(plant=plant, seed=seed),
        resume=False,
        clock=lambda: start,
        report=lambda progress: None,
    )


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Serve the page of a station, and return its address."""
    server = new_server(workflow.Station(folder), 0)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/"
    finally:
        server.shutdown()
        thread.join()


def picture(page: Path | str, target: Path, height: int) -> None:
    """Write a picture of the top of a page, with few colours so that the file is small."""
    with tempfile.TemporaryDirectory() as name:
        shot = Path(name) / "shot.png"
        address = page if isinstance(page, str) else page.resolve().as_uri()
        subprocess.run(
            ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
            + [f"--window-size={WIDTH},{height}", f"--screenshot={shot}"]
            + ["--virtual-time-budget=4000", f"--user-data-dir={name}/profile", address],
            check=True,
            capture_output=True,
        )
        image = Image.open(shot).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
        image.save(target, optimize=True)


if __name__ == "__main__":
    main()

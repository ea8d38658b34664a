"""An outside programmer is run as the bench file says; its return code counts, its output stays."""

import os
import pty
import sys
import threading
import time
from pathlib import Path

import pytest
import yaml

from hbench import workflow
from hbench.config.bench import parse_bench
from hbench.errors import ConfigError, DeviceError, ExitCode
from hbench.rig.flash.programmer import flash_through, run_programmer
from tests.support.board.boot_rom_standin import FIRMWARE, PROGRAM_BAUD, BootLine, BootRom, Program

BENCH = Path(__file__).parents[2] / "configs" / "bench-aau.yaml"


def python(code: str, *arguments: str) -> list[str]:
    return [sys.executable, "-c", code, *arguments]


@pytest.fixture
def image(tmp_path):
    path = tmp_path / "a firmware.out"
    path.write_bytes(b"\xc2\x00" + f"{FIRMWARE}\0f28335\0".encode("utf-16-le"))
    return path


def board(firmware: str = FIRMWARE, running: bool = True):
    program = Program(firmware) if running else None
    return lambda baud: BootLine(BootRom(flash_program=program, boots_from_flash=True), baud)


def test_the_image_takes_its_place_and_the_output_is_kept(image):
    code = "import sys; print('file', sys.argv[1:]); print('done', file=sys.stderr)"
    log = run_programmer(python(code, "-f", "{image}", "x={image}"), 20.0, image)
    text = log.read_text()
    assert f"file ['-f', '{image}', 'x={image}']" in text and "done" in text
    assert log == image.with_name("a firmware.out.programmer.log")


def test_no_shell_reads_the_arguments(image):
    log = run_programmer(python("import sys; print(sys.argv)", "{image}; $HOME"), 20.0, image)
    assert "; $HOME" in log.read_text()


def test_a_failing_programmer_is_a_device_error_with_its_code_and_last_line(image):
    code = "import sys; print('erase'); print('lost\\n'); sys.exit(7)"
    with pytest.raises(DeviceError, match=r"code 7\b.*: lost") as error:
        run_programmer(python(code, "{image}"), 20.0, image)
    assert error.value.exit_code == ExitCode.DEVICE
    log = image.with_name(image.name + ".programmer.log")
    assert str(log) in error.value.hint
    assert log.read_text() == "erase\nlost\n\n"


def test_a_hanging_programmer_is_ended_with_its_children(image):
    alive = image.with_name("alive")
    child = f"import time, pathlib; time.sleep(1.5); pathlib.Path({str(alive)!r}).touch()"
    parent = (
        "import subprocess, sys; print('waiting', flush=True); "
        f"subprocess.run([sys.executable, '-c', {child!r}])"
    )
    start = time.monotonic()
    with pytest.raises(DeviceError, match="0.7 s: waiting"):
        run_programmer(python(parent, "{image}"), 0.7, image)
    assert time.monotonic() - start < 1.4
    time.sleep(1.2)
    assert not alive.exists()


def test_a_missing_programmer_is_a_usage_error(image):
    with pytest.raises(ConfigError, match="no-such-programmer"):
        run_programmer(["no-such-programmer", "{image}"], 5.0, image)


def test_a_missing_image_is_a_usage_error_before_anything_runs(tmp_path):
    with pytest.raises(ConfigError, match="none.out"):
        flash_through(["no-such-programmer", "{image}"], 5.0, tmp_path / "none.out", board(), 1)


def test_after_flashing_the_board_is_asked_who_it_is(image):
    command = python("", "{image}")
    identity = flash_through(command, 20.0, image, board(), PROGRAM_BAUD)
    assert identity.firmware == FIRMWARE


def test_a_board_that_kept_its_old_program_is_found_out(image):
    with pytest.raises(DeviceError, match="'hbench-core 0.0'"):
        flash_through(python("", "{image}"), 20.0, image, board("hbench-core 0.0"), PROGRAM_BAUD)


def test_a_silent_board_after_flashing_is_told(image):
    with pytest.raises(DeviceError, match="'identify'"):
        flash_through(python("", "{image}"), 20.0, image, board(running=False), PROGRAM_BAUD)


def test_an_image_of_octets_is_searched_too(image):
    image.write_bytes(b"\x7fELF" + FIRMWARE.encode() + b"\0f28335\0")
    assert flash_through(python("", "{image}"), 20.0, image, board(), PROGRAM_BAUD)


def test_an_image_for_another_board_is_an_error(image):
    image.write_bytes(b"\x7fELF" + FIRMWARE.encode() + b"\0stm32f4\0")
    with pytest.raises(DeviceError, match="board 'f28335' not found in .*: the image is for"):
        flash_through(python("", "{image}"), 20.0, image, board(), PROGRAM_BAUD)


def bench_with(programmer) -> dict:
    data = yaml.safe_load(BENCH.read_text())
    return data if programmer is None else data | {"programmer": programmer}


@pytest.mark.parametrize(
    "programmer, fault",
    [
        ({"command": ["flasher", "image"], "timeout": "60 s"}, "{image}"),
        ({"command": [], "timeout": "60 s"}, "programmer.command"),
        ({"command": ["flasher", "{image}"]}, "programmer.timeout"),
        ({"command": "flasher {image}", "timeout": "60 s"}, "programmer.command"),
    ],
)
def test_a_programmer_that_can_not_work_is_refused_in_the_bench_file(programmer, fault):
    with pytest.raises(ConfigError) as error:
        parse_bench(bench_with(programmer), "bench.yaml")
    assert fault in error.value.message


def test_a_bench_without_a_programmer_says_so(image, tmp_path):
    path = tmp_path / "bench.yaml"
    path.write_text(yaml.safe_dump(bench_with(None)))
    with pytest.raises(ConfigError, match="'programmer'"):
        workflow.flash_through_programmer(image, path, "/dev/none", PROGRAM_BAUD)


def test_the_command_line_flashes_through_the_bench_file(image, tmp_path, monkeypatch, capsys):
    from hbench.cli.main import main

    path = tmp_path / "bench.yaml"
    command = python("import sys; print(sys.argv[1])", "{image}")
    path.write_text(yaml.safe_dump(bench_with({"command": command, "timeout": "20 s"})))
    master, slave = pty.openpty()
    line = board()(PROGRAM_BAUD)

    def answer():
        while True:
            try:
                line.write(os.read(master, 64))
            except OSError:
                return
            while data := line.read(1.0):
                os.write(master, data)

    threading.Thread(target=answer, daemon=True).start()
    words = ["hbench", "flash", str(image), "--port", os.ttyname(slave), "--bench", str(path)]
    monkeypatch.setattr("sys.argv", words)
    with pytest.raises(SystemExit) as end:
        main()
    os.close(slave)
    os.close(master)
    assert end.value.code == 0
    assert f"'{FIRMWARE}'" in capsys.readouterr().out
    assert str(image) in image.with_name(image.name + ".programmer.log").read_text()

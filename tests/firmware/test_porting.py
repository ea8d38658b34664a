"""The page about ports: its board, which does not exist, is built as the page says."""

import re
import shutil
import subprocess

from tests.support.board.f28335_board import ROOT

FIRMWARE = ROOT / "firmware"


def test_the_pages_port_links_and_contains_the_core(tmp_path, require_tool):
    for tool in ("cmake", "arm-none-eabi-gcc"):
        require_tool(tool)
    page = (FIRMWARE / "PORTING.md").read_text()
    firmware = shutil.copytree(FIRMWARE, tmp_path / "firmware")
    files = re.findall(r"<!-- file: (\S+) -->\n```\w+\n(.*?)\n```\n", page, re.DOTALL)
    assert len(files) == 4
    for name, text in files:
        path = firmware / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text + "\n")
    (commands,) = re.findall(r"<!-- build -->\n```sh\n(.*?)\n```\n", page, re.DOTALL)
    done = subprocess.run(["sh", "-ec", commands], cwd=firmware, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    image = tmp_path / "build" / "acme" / "hbench-acme.elf"
    symbols = subprocess.run(
        [require_tool("arm-none-eabi-nm"), image], capture_output=True, text=True, check=True
    ).stdout.split()
    assert {"hb_core_tick", "hb_link_poll", "control_interrupt"} <= set(symbols)
    print(done.stdout.splitlines()[-2])

"""A message tells in which line of the file a key stands."""

import pytest
import yaml

from hbench.config.bench import parse_bench
from hbench.config.files import key_lines
from hbench.config.files.key_lines import with_lines
from hbench.config.files.yaml_text import compose_yaml, parse_yaml
from hbench.errors import ConfigError
from tests.support import ROOT

TEXT = """\
# a comment
name: x
experiments:
  - kind: steady
    loads: [500 N,
            5000]
    velocities: &speeds {first: 5 mm/s,
      last: 2}
  - kind: ramp
    velocities: *speeds
"""


@pytest.mark.parametrize(
    ("told", "line"),
    [
        ("experiments.0.loads.1 = 5000: wrong", 6),
        ("experiments.0.loads: 5000 N: wrong", 5),
        ("experiments.1.velocities.last = 2: wrong", 8),  # where the alias's value stands
        ("unknown key 'experiments.1.kind'", 9),
        ("key 'experiments.1.loads': wrong", 9),  # in the section that begins there
        ("experiments: wrong", 3),
        ("key 'bench': wrong", None),
        ("wrong", None),
    ],
)
def test_the_line_of_a_key_or_of_the_nearest_above_it(tmp_path, told, line):
    file = tmp_path / "my schedule.yaml"
    file.write_text(TEXT)
    placed = f"{file}: line {line}: {told}" if line else f"{file}: {told}"
    assert with_lines(f"{file}: {told}") == placed
    assert with_lines(f"first\n{file}: {told}") == f"first\n{placed}"


@pytest.mark.parametrize("content", [None, b"a: [1", b"\xff\xfe", b"- 1\n", b"a: 1\n---\na: 2\n"])
def test_a_file_without_keys_leaves_the_message_as_it_is(tmp_path, content):
    file = tmp_path / "x.yaml"
    if content is not None:
        file.write_bytes(content)
    assert with_lines(f"{file}: a = 1: wrong") == f"{file}: a = 1: wrong"


def test_a_large_file_full_of_faults_is_read_once(tmp_path, monkeypatch):
    file = tmp_path / "bench.yaml"
    file.write_text("".join(f"extra_{i}: [1, 2, 3]\n" for i in range(2000)))
    example = yaml.safe_load((ROOT / "configs" / "bench-aau.yaml").read_text())
    read = []
    monkeypatch.setattr(
        key_lines, "compose_yaml", lambda text: read.append(text) or compose_yaml(text)
    )
    with pytest.raises(ConfigError) as caught:
        parse_bench(example | parse_yaml(file.read_text()), str(file))
    lines = with_lines(caught.value.message).split("\n")
    assert len(read) == 1
    assert "line 50: unknown key 'extra_49'" in "\n".join(lines)
    assert lines[-1].startswith(f"{file}: ") and lines[-1].endswith(" more faults")
    assert len(lines) == 51

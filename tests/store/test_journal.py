import pytest
import yaml

from hbench.errors import DataError
from hbench.store.campaign import journal
from hbench.store.campaign.journal import Stop, intact_length, parse_journal

STOP = Stop("2024-05-01T12:00:02+00:00", "done", 4, "ab" * 32)


@pytest.fixture
def parts(header, make_plan, at):
    """A journal in the pieces in which it is appended."""
    failed = Stop(
        "2024-05-01T12:00:04+00:00", "failed", 0, "cd" * 32, 'no: reply,\n {"}] # - run: ü'
    )
    return [
        journal.journal_header(header),
        journal.start_text(make_plan("0001"), at(1)),
        journal.stop_text(STOP),
        journal.start_text(make_plan("0002", label="NBR, 70 Shore", motion=None), at(3)),
        journal.stop_text(failed),
        journal.start_text(make_plan("0003", f_load_n=None), at(5)),
    ]


def test_journal_is_valid_yaml_after_every_append(parts):
    for count in range(1, len(parts) + 1):
        content = yaml.safe_load("".join(parts[:count]))  # the plain loader: another reader
        assert content["schema"] == "hbench.campaign/1"
        assert len(content["runs"] or []) == count // 2


def test_what_was_written_comes_back(header, parts, make_plan):
    content = parse_journal("".join(parts).encode(), "campaign.yaml")
    assert content.header == {"schema": "hbench.campaign/1", **header}
    assert [entry.plan for entry in content.entries] == [
        make_plan("0001"),
        make_plan("0002", label="NBR, 70 Shore", motion=None),
        make_plan("0003", f_load_n=None),
    ]
    assert content.entries[0].stop == STOP
    assert content.entries[1].stop.why == 'no: reply,\n {"}] # - run: ü'
    assert content.entries[2].stop is None
    assert content.warnings == ()


def test_a_tail_torn_at_any_byte_costs_no_earlier_part(parts):
    text = "".join(parts).encode()
    ends = [len("".join(parts[: n + 1]).encode()) for n in range(len(parts))]
    for length in range(ends[0], len(text) + 1):
        whole = sum(end <= length for end in ends)  # pieces that are there in full
        content = parse_journal(text[:length], "campaign.yaml")
        assert intact_length(text[:length]) == ends[whole - 1]
        assert len(content.entries) == whole // 2
        assert [e.stop is not None for e in content.entries[:2]] == [whole >= 3, whole >= 5][
            : len(content.entries)
        ]
        assert bool(content.warnings) == (length not in ends)


def test_torn_tail_is_told_with_its_line(parts):
    text = "".join(parts[:2]) + "  stop: {at: '20"
    line = text.count("\n") + 1
    warnings = parse_journal(text.encode(), "campaign.yaml").warnings
    assert warnings[0].startswith(f"campaign.yaml: line {line}: half-written")


def test_values_are_written_out_each_time_not_by_reference(header):
    shared = {"piston_diameter": "25 mm"}
    text = journal.journal_header({**header, "a": shared, "b": shared})
    assert "&" not in text and "*" not in text


@pytest.mark.parametrize("run", ["../0001", "a/b", "a\\b", "", "..", ".", "~1", "a b", "x" * 101])
def test_run_that_could_leave_the_folder_is_refused(run, make_plan, at):
    with pytest.raises(DataError, match="campaign: run "):
        journal.start_text(make_plan(run), at(0))


def test_broken_yaml_is_refused_with_its_line(parts):
    text = parts[0] + "- run: '0001'\n  plan: {kind: [}\n  start: {at: x}\n"
    line = parts[0].count("\n") + 2
    with pytest.raises(DataError, match=f"campaign.yaml: line {line}: "):
        parse_journal(text.encode(), "campaign.yaml")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("hbench.campaign/1", "hbench.campaign/9", "'hbench.campaign/9'.*'hbench.campaign/1'"),
        ("name: test\n", "", "'name'"),
        ('"kind": "steady"', '"sort": "steady"', "campaign.yaml: runs.0: "),
        ("'0001'", "'../1'", "campaign.yaml: runs.0: run '../1'"),
    ],
)
def test_journal_of_another_make_is_refused(parts, old, new, message):
    text = "".join(parts).replace(old, new, 1)
    with pytest.raises(DataError, match=message):
        parse_journal(text.encode(), "campaign.yaml")


def test_an_edited_section_is_told_by_its_name(parts, header):
    header["bench"] = {"file": "b.yaml", "content": {"area": "200 mm^2"}}
    text = journal.journal_header(header) + "".join(parts[1:3])
    assert parse_journal(text.encode(), "c").warnings == ()
    edited = text.replace("200 mm^2", "210 mm^2").replace("rate_hz: 100.0", "rate_hz: 50.0")
    (warning,) = parse_journal(edited.encode(), "c").warnings
    assert warning.startswith("c: bench, log: ")


def test_an_edited_plan_is_told_by_its_run(parts):
    text = "".join(parts)
    edited = text.replace('"f_load_n": -500.0', '"f_load_n": 500.0', 1)
    (warning,) = parse_journal(edited.encode(), "c").warnings
    assert "plan of 0001: " in warning


def test_layout_and_comments_of_the_journal_are_free(parts):
    text = "".join(parts)
    content = yaml.safe_load(text)
    for other in (f"# mine\n{text}", yaml.safe_dump(content, sort_keys=False)):
        assert parse_journal(other.encode(), "c").warnings == ()


def test_a_journal_of_before_there_were_hashes_is_read_without_a_word(parts):
    content = yaml.safe_load("".join(parts))
    del content["sha256"]
    for run in content["runs"]:
        del run["start"]["plan_sha256"]
    text = yaml.safe_dump(content, sort_keys=False)
    assert parse_journal(text.encode(), "c").warnings == ()

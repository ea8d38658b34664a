"""The schemas of ``results.json`` and ``diagnosis.json``, for other programs: true and complete."""

import json
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path

import pytest

from hbench.report.campaign.results_document import results_json
from hbench.report.diagnosis.diagnosis_document import diagnosis_json
from hbench.report.json_documents.layout import NullIfEmpty
from hbench.report.json_documents.schema import schema
from hbench.report.schemas import schema_text
from hbench.store.campaign.folder import load_campaign
from hbench.workflow.results import derive
from tests.support.reconcile import made_diagnosis as made

SAMPLES = Path(__file__).parents[2] / "data_samples"
# Objects of no fixed names.
BY_NAME = (
    "software",
    "details",
    "settings",
    "parameters",
    "intervals",
    "parts",
    "parts_n",
    "parameters_si",
)
BY_NAME += (
    "factors",
    "balances",
    "signals",
    "open_loop",
    "refitted",
    "refit_priors",
    "gaps",
    "not_tried",
    "ruled_out",
    "next_schedule",
    "zero_tolerances",
    "delays",
    "also",
)


def objects(value, place=""):
    """Yield every object in a document whose names are fixed, with its place.

    The items of a list have one place, as have those of an object whose names are not fixed.
    """
    if isinstance(value, dict):
        fixed = place.rpartition(".")[2] not in BY_NAME
        if fixed:
            yield place, value
        for name, item in value.items():
            yield from objects(item, f"{place}.{name}" if fixed else f"{place}.*")
    elif isinstance(value, list):
        for item in value:
            yield from objects(item, f"{place}[]")


@pytest.mark.parametrize("name", ["stribeck", "seals", "two_rod_sides"])
def test_made_up_results_hold_what_the_schema_tells_and_nothing_else(name, request, schema_faults):
    assert not schema_faults(json.loads(results_json(request.getfixturevalue(name))))


@pytest.mark.parametrize("name", ["stribeck-small", "bad-runs"])
def test_the_sample_campaigns_hold_what_the_schema_tells_and_nothing_else(name, schema_faults):
    assert not schema_faults(json.loads(results_json(derive(load_campaign(SAMPLES / name)))))


@pytest.mark.parametrize(
    "spoil",
    [
        lambda one, key: one.pop(key),
        lambda one, key: one.update(another=1),
        lambda one, key: one.update({key: [[]]}),
    ],
    ids=["missing", "another", "wrong"],
)
def test_no_key_may_be_missing_none_be_added_and_no_value_be_of_another_type(
    spoil, small, schema_faults
):
    few = replace(small, runs=small.runs[:2], curves=small.curves[:1])
    diagnosis = replace(made.named(), gap_runs=made.named().gap_runs[:1])
    documents = {"results": results_json(few), "diagnosis": diagnosis_json(diagnosis)}
    for name, text in documents.items():
        document = json.loads(text)
        for place, one in dict(objects(document)).items():
            good = dict(one)
            spoil(one, next(iter(good)))
            assert schema_faults(document, name), place
            one.clear()
            one.update(good)
        assert not schema_faults(document, name)


@pytest.mark.parametrize("name", ["results", "diagnosis"])
def test_the_packaged_schemas_are_those_of_the_records(name):
    room = "campaign" if name == "results" else "diagnosis"
    packaged = files(f"hbench.report.{room}") / f"{name}.schema.json"
    command = f"python -m hbench.report.schemas {name} > hbench/report/{room}/{name}.schema.json"
    assert packaged.read_text() == schema_text(name), command


def test_a_schema_follows_the_types_comments_and_units_of_a_record():
    made = schema("pair/1", "t", "d", Pair, {Pair: {"a": "low_n", "b": NullIfEmpty("word")}})
    assert made["properties"] == {
        "a": {"type": ["number", "null"], "description": "low; null: none [N]"},
        "b": {"type": ["string", "null"]},
    }
    assert made["required"] == ["a", "b"] and made["$id"] == "urn:hbench:pair:1"


@dataclass(frozen=True)
class Pair:
    """A record of this test."""

    low_n: float | None  # low; None: none
    word: str


@pytest.mark.parametrize("make", [made.named, made.ambiguous, made.unknown])
def test_diagnoses_hold_what_their_schema_tells_and_nothing_else(make, schema_faults):
    assert not schema_faults(json.loads(diagnosis_json(make())), "diagnosis")

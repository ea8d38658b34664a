"""Made-up diagnoses of every verdict, for tests of their words."""

from dataclasses import replace

from hbench.reconcile.diagnosis_fields import ModelledData, insufficient_data_diagnosis
from hbench.records import (
    AddedEffect,
    BeforeAfter,
    Candidate,
    Change,
    EffectInPractice,
    FitParameter,
    Gap,
    GapTable,
    Lookalike,
    Provenance,
    Region,
    Rival,
    WorkingPoint,
)
from hbench.report.diagnosis.summary import answers

NAN = float("nan")
POINT = WorkingPoint(
    "extend", 12, 0.08, 0.2, 2490.0, 63e5, 52.1e5, 40e5, 15e5, 150e5, 1.0, 0.5, -1.0,
    {"flow_tp": 1e-6, "force_test": 38.4},
)  # fmt: skip
LEAK = EffectInPractice(
    "internal_leakage",
    (
        Change("flow_tp", "l/min", -0.18, (-0.19, -0.17), 0.21, 0.35),
        Change("flow_tr", "l/min", 0.18, (0.17, 0.19), 0.21, 0.35),
        Change("speed", "mm/s", -2.4, (-2.5, -2.3), 2.8, 4.6),
        Change("force_load", "N", 1e-4, None, 5.0, 9.0),
    ),
    "the piston seal",
    "Replace it.",
    (Lookalike("external_leakage", "hold", "pressures meet, or each falls to zero"),),
)
CELL = EffectInPractice(
    "load_cell_gain",
    (
        Change("f_applied", "N", 49.8, None, 60.0, 100.0),
        Change("force_test", "N", -49.8, None, 60.0, 100.0),
    ),
    "known weights",
    "Calibrate it.",
    (),
)


def summary(diagnosis):
    """Return all answers as one text."""
    return " ".join(text for _, text in answers(diagnosis))


def few():
    """Return a diagnosis of too few runs."""
    about = Provenance("made", "simulated", "bench", "sim", "2026-01-01T00:00:00", "")
    task = ModelledData(provenance=about, model="model.yaml", plant_data={})
    return insufficient_data_diagnosis(task, ("a second load",), ())


def compared():
    """A diagnosis with gaps, candidates and a working point, and nothing named."""
    gap = BeforeAfter(12.0, 9.5, 9.5, 1.2)
    table = GapTable(gap, {"flow_tp": gap}, {}, {})
    where = (
        Gap("force_test", 5.5, 0.01, 7.3, 580, 40.0, 12.0, 113.0),
        Gap("flow_tp", 1.1, 0.5, 1e-7, 580, 1e-7, 4e-7, 1e-6),
    )
    ranking = (
        Candidate("load_friction", 27.3, 0.8, 0.22, {}, "full", 5.0),
        Candidate("position_friction", 4.0, 0.1, 1.0, {}, "full", 5.0),
    )
    regions = tuple(
        Region("direction", label, NAN, NAN, 200, {"force_test": value})
        for label, value in (("extend", 2.0), ("retract", 9.0))
    ) + (
        Region("speed_m_s", "", 0.01, 0.05, 100, {"force_test": 5.0}),
        Region("speed_m_s", "", 0.05, 0.2, 100, {"force_test": 5.5}),
    )
    return replace(
        few(), where=where, rest=where[:1], ranking=ranking, gap_heldout=table, regions=regions,
        working_point=POINT, missing=(), next_experiment=None, heldout_runs=("3", "8"),
    )  # fmt: skip


def added(name, margin, of_sensor=False):
    """Return an effect with the margin to the next best one."""
    parameters = {"test": FitParameter(0.003, 1e-4, (0.0028, 0.0032), None, "l/min/bar")}
    rival = None if margin is None else Rival("external_leakage", margin)
    return AddedEffect(name, "oil leaks", parameters, of_sensor, 16.7, 1.6, 140.0, rival)


def named():
    """Return a diagnosis with a leak."""
    return replace(
        compared(), verdict="named", effects=(added("internal_leakage", 119.0),), rest=(),
        practice=(LEAK,),
    )  # fmt: skip

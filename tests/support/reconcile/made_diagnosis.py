"""Diagnoses of campaigns that the virtual rig made, for the report: no search is in them.

Residuals, gaps and overlays are those of the runs; scores and intervals are made up.
"""

import json
import zlib
from dataclasses import replace
from functools import cache

import numpy as np

from hbench.config.bench import parse_bench, parse_plant
from hbench.config.files.loading import read_yaml
from hbench.experiment.closed_loop import record
from hbench.model.effects.catalogue import read_effects
from hbench.reconcile.gaps.gap_map import point_of
from hbench.reconcile.gaps.log_map import ranked_gaps, unexplained_gaps
from hbench.reconcile.gaps.regions import regions
from hbench.reconcile.gaps.tables import BalanceStages, SimulatedStages, gap_table, gaps_of_runs
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.measured.balances import BALANCES
from hbench.records import (
    AddedEffect,
    Candidate,
    Diagnosis,
    FitParameter,
    Overlay,
    Provenance,
    ResidualMap,
    Rival,
)
from hbench.report.diagnosis.figures.all_figures import draw_diagnosis
from hbench.report.render.figures import Drawing
from tests.support import ROOT
from tests.support.reconcile.rounds import campaign_of, schedule
from tests.support.shared import once

BENCH = read_yaml(ROOT / "configs" / "bench-aau.yaml")
GIVEN = {"valve": {"gain": "7.6e-7 m^2/V"}, "friction": {"test": {"viscous": "2600 N s/m"}}}
LEAK = {"internal_leakage": {"test": "0.006 l/min/bar"}}
FOUND = {"internal_leakage": {"test": "0.0058 l/min/bar"}}
PLAN = schedule(trials=2, speeds=("20 mm/s", "150 mm/s"))
SHOWN = {"v": ("v_m_s", "m/s"), "p_tp": ("p_tp_pa", "Pa"), "f_applied": ("f_applied_n", "N")}


def diagnosis(hidden=LEAK, found=FOUND) -> Diagnosis:
    """Return what a search would, had it added ``found`` to the model of a bench with ``hidden``.

    With nothing found the verdict is ``unknown``, or ``none`` where nothing is hidden.
    """
    bench = parse_bench(BENCH, "bench")
    measured = _runs({"effects": hidden}, 5)
    plants = (GIVEN, {}, {"effects": found})
    before, refitted, after = (_runs(over, seed) for seed, over in enumerate(plants, 77))
    held = _held_out(measured)
    own = campaign_of(measured, bench, parse_plant(BENCH, {}, "model"))
    hypotheses = _hypotheses(found)
    maps = [own.gap_map(hypothesis) for hypothesis in hypotheses]
    maps = [each.in_units_of(maps[1]) for each in maps]
    balances = BalanceStages(tuple(maps), np.full(maps[0].difference.shape, 1.04))
    models = [own.balance_model(hypothesis) for hypothesis in hypotheses]
    simulated = list(zip((before, refitted, after), models, strict=True))
    stages = SimulatedStages(measured, simulated, (0, 1, 2), held)
    allowed = np.full(len(BALANCES), 1e-7)
    where, rest = (ranked_gaps(each, allowed) for each in maps[1:])
    lacked, lacks = maps[1:]
    table = gap_table(balances, stages, held)
    heldout_runs = tuple(run.plan.run for run in measured if point_of(run.plan) in held)
    verdict = "named" if found else "unknown" if hidden else "none"
    return Diagnosis(
        provenance=Provenance("made <up>", "simulated", "bench", "sim", "2026-01-01T00:00:00", ""),
        model="model-aau.yaml",
        verdict=verdict,
        why=_WHY[verdict],
        where=where,
        regions=regions(lacked),
        regions_after=regions(lacks),
        effects=tuple(_added(name, table) for name in found),
        alternatives=(),
        rest=unexplained_gaps(rest) if verdict == "unknown" else (),
        next_experiment=None,
        next_schedule=None,
        gap_heldout=table,
        gap_train=gap_table(balances, stages, frozenset(lacked.points) - held),
        gap_runs=gaps_of_runs([run.plan for run in measured], balances, stages, held),
        ranking=_ranking(found),
        threshold=14.0,
        refitted={
            "valve.gain": FitParameter(0.978, 0.002, (0.974, 0.982), None, "1"),
            "friction.test.viscous": FitParameter(0.96, 0.011, (0.938, 0.982), None, "1"),
            "moving_mass.test": FitParameter(0.55, None, None, "lower", "1"),
        },
        refit_priors={"valve.gain": 0.15, "friction.test.viscous": 0.8, "moving_mass.test": 0.2},
        residuals_before=_map(lacked, held),
        residuals_after=_map(lacks, held),
        overlays=_overlays(measured, refitted, after, heldout_runs),
        heldout_runs=heldout_runs,
        not_tried={"presliding": "no run reverses"},
        missing=(),
        left_out=("0007 (steady): speed: 3.1 mm/s off its reference",),
        revised={"effects": found} if found else {},
        notes=("made on the virtual rig",),
    )


def _hypotheses(found):
    """Return those of the models as given, refitted, and with what was found."""
    gain = 7.6e-7 / 7.43e-7
    si = {name: read_effects({name: values})[name] for name, values in found.items()}
    return (
        Hypothesis({"valve.gain": gain, "friction.test.viscous": 2600 / 2500}),
        Hypothesis(),
        Hypothesis(effects=si),
    )


def _runs(over, seed):
    """Return the runs of a plant on the virtual rig."""

    def make():
        plant = parse_plant(BENCH, over, "plant")
        made = record(parse_bench(BENCH, "bench"), PLAN, plant, seed=seed)
        assert not made.stopped
        return made.runs

    return once(f"made-{zlib.crc32(json.dumps([over, seed]).encode()):08x}", make)


_WHY = {
    "named": "Leakage across the test piston explains 97 % of the excess gap; the next is far off.",
    "unknown": "Flows lack something that no candidate explains.",
    "none": "No balance stands out of the trials' scatter.",
    "ambiguous": "Two effects explain the flows equally well.",
}


@cache
def named() -> Diagnosis:
    """Return a leak that was found, and put right."""
    return once("diagnosis-named", diagnosis)


def drawings_of_named() -> tuple[Drawing, ...]:
    """Return the figures of ``named``."""
    return once("drawings-named", lambda: draw_diagnosis(named()))


@cache
def unknown() -> Diagnosis:
    """Return a leak that nothing explained."""
    return once("diagnosis-unknown", lambda: diagnosis(found={}))


def ambiguous() -> Diagnosis:
    """Return a set of two, and a schedule that would tell them apart."""
    first, second = named().ranking[:2]
    return replace(
        named(),
        verdict="ambiguous",
        why=_WHY["ambiguous"],
        effects=(),
        alternatives=(first, second),
        next_experiment="Hold at two pressures with closed valves.",
        next_schedule=schedule(),
        missing=("closed valves (runs of kind hold)",),
    )


def _held_out(runs):
    """Return every third operating point."""
    return frozenset(list(dict.fromkeys(point_of(run.plan) for run in runs))[1::3])


def _map(found, held):
    out = np.array([point in held for point in found.points])
    with np.errstate(divide="ignore", invalid="ignore"):
        value = found.difference / found.scatter
    places = (found.v_m_s, found.load_n, found.x_m, found.t_s)
    return ResidualMap(found.names, value, *places, out[found.point])


def _overlays(measured, before, after, chosen):
    by_run = [{run.plan.run: run for run in side} for side in (measured, before, after)]
    shown = (chosen[0], chosen[-1])
    found = []
    for run in shown:
        three = [side[run] for side in by_run]
        n = min(len(one.t_s) for one in three)
        for signal, (field, unit) in SHOWN.items():
            traces = [getattr(one, field)[:n] for one in three]
            found.append(Overlay(run, signal, unit, three[0].t_s[:n], *traces))
    return tuple(found)


def _added(name, table):
    flows = table.balances["flow_tp"]
    return AddedEffect(
        name=name,
        description="oil leaks across the piston with the pressure drop",
        parameters={"test": FitParameter(0.0058, 1e-4, (0.0056, 0.0061), None, "l/min/bar")},
        of_sensor=False,
        gap_before=flows.refitted,
        gap_after=flows.after,
        score=812.0,
        runner_up=Rival("external_leakage", 231.0),
        shape="exponent 1.2 (1.1 to 1.3) of the pressure drop",
    )


def _ranking(found):
    best = 812.0 if found else 9.0
    names = (
        "internal_leakage",
        "external_leakage",
        "valve_asymmetry",
        "pressure_offset",
        "valve_lag",
    )
    scores = (best, best - 0.28 * best, 0.2 * best, 0.08 * best, -3.0)
    return tuple(
        Candidate(
            name,
            score,
            score / best,
            2.0,
            {"test": 1e-12},
            "full" if i < 3 else "linear",
            14.0,
        )
        for i, (name, score) in enumerate(zip(names, scores, strict=True))
    )

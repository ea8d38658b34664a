"""Made-up results of a seal's strokes at several pressures, drawn around known lines."""

from dataclasses import replace

import numpy as np

from hbench.analysis.curves.band_trends import band_trends
from hbench.analysis.curves.bands import friction_bands
from hbench.analysis.summary.headline import headline
from hbench.analysis.summary.quality import quality
from hbench.records import (
    Curve,
    CurvePoint,
    Provenance,
    Results,
    Run,
    RunPlan,
    ScreenedRun,
    Specimen,
)

BARS = (1.0, 3.0, 5.0, 7.0)
MIDDLE_N_BAR, STROKE_M = -0.4, 0.04
SMALL, LARGE = Specimen(4.909e-4, 4.909e-4), Specimen(5.187e-4, 5.187e-4)


def drawn_seal(
    seed,
    label="A",
    *,
    level=4.0,
    slope=0.6,
    scatter=0.1,
    specimen=SMALL,
    speeds=(8.3e-3, 6e-3),
    pressure=1.0,
    bars=BARS,
    trials=5,
    speed_is_measured=True,
):
    """Half band ``level`` + ``slope`` p [N, N/bar]; ``pressure`` is measured over nominal."""
    rng = np.random.default_rng(seed)
    curves, runs = [], []
    for bar in bars:
        load = bar * 1e5 * specimen.area_piston_m2
        half = level + slope * bar + scatter * rng.standard_normal(trials)
        for direction, sign, v in zip(("extend", "retract"), (1, -1), speeds, strict=True):
            noise = scatter * rng.standard_normal(trials)
            drawn = sign * half + MIDDLE_N_BAR * bar + noise
            numbers = tuple(range(1, trials + 1))
            point = CurvePoint(
                v_m_s=sign * v,
                friction_n=float(drawn.mean()),
                ci95_n=None,
                n=trials,
                f_test_n=load,
                f_applied_n=load - float(drawn.mean()),
                p_tp_pa=pressure * bar * 1e5,
                p_tr_pa=0.0,
                trials=numbers,
                trials_n=tuple(drawn.tolist()),
                trials_f_test_n=(load,) * trials,
                runs=(),
                trials_work_j=tuple((sign * STROKE_M * drawn).tolist()),
            )
            curves.append(Curve("steady", direction, load, None, label, specimen, (point,)))
            for trial in numbers:
                plan = RunPlan(
                    f"{len(runs):04d}", "steady", trial, sign * v, specimen, f_load_n=load,
                    label=label, speed_is_measured=speed_is_measured,
                )  # fmt: skip
                runs.append(ScreenedRun(Run(plan, np.zeros(0), np.zeros(0)), (), None))
    bands = friction_bands(curves)
    return Results(
        Provenance(f"seal {label}", "imported", "", "", "2026-01-01T00:00:00+00:00", ""),
        tuple(runs),
        tuple(curves),
        (),
        bands,
        (),
        band_trends=band_trends(bands),
        headline=headline(curves, ()),
        quality=quality(runs, curves),
    )


def of_two_speeds(slow, fast):
    """Results of one campaign with the strokes of both, whose pressures are the same."""
    curves = tuple(
        replace(one, points=(*one.points, *other.points))
        for one, other in zip(slow.curves, fast.curves, strict=True)
    )
    bands, runs = friction_bands(curves), (*slow.runs, *fast.runs)
    return replace(slow, runs=runs, curves=curves, bands=bands, band_trends=band_trends(bands))

"""Tables of effects: named, not distinguishable, and tried."""

from hbench.records import Candidate, Diagnosis, WordTable
from hbench.report.diagnosis.names import gap_number, share, value_words
from hbench.report.diagnosis.words.candidate import too_small
from hbench.report.diagnosis.words.coefficient import (
    coefficient_text,
    coefficient_words,
    parameter_text,
)
from hbench.report.render.numbers import NONE, number

_NO_GAIN = 0.05  # nats that are written as 0
_RANK_HEAD = (
    *("candidate", "score (nats)", "must exceed", "explains", "size"),
    *("why not named", "tried"),
)
Rows = tuple[tuple[str, ...], ...]


def effects_table(diagnosis: Diagnosis) -> WordTable:
    """Return a row for each coefficient, with what its effect does to runs outside the fit.

    That of strokes is in the table of the force errors at loads outside the fit.
    """
    rows, in_scatters = [], not diagnosis.held_out_loads
    for added in diagnosis.effects:
        rival = NONE
        if added.runner_up:
            score = added.score - added.runner_up.margin
            rival = f"{added.runner_up.name}, {number(score + 0.0, 1)}"
        gaps = (gap_number(added.gap_before), gap_number(added.gap_after))
        gains = (
            *(gaps if in_scatters else ()),
            "yes" if added.confirmed else "no",
            number(added.score + 0.0, 1),
            rival,
        )
        for i, name in enumerate(added.parameters):
            effect, cells = ("", ("",) * len(gains)) if i else (added.name, gains)
            words = coefficient_words(name, added.name)
            rows.append((effect, words, coefficient_text(added, name), *cells))
    of_gaps = (
        ", and gaps of runs outside the fit in the quantities that they change"
        if in_scatters
        else ""
    )
    head = (
        *("effect", "coefficient", "value with 95 % interval"),
        *(("gap without it", "with it") if in_scatters else ()),
        *("in model.yaml", "score (nats)", "next best, its score"),
    )
    return WordTable(f"Effects{of_gaps}", head, tuple(rows))


def alternatives_table(diagnosis: Diagnosis) -> WordTable:
    """Return the ambiguous set."""
    return WordTable(
        "Effects that these data cannot distinguish",
        _RANK_HEAD,
        _ranked(diagnosis, diagnosis.alternatives),
    )


def ranking_table(diagnosis: Diagnosis, most: int | None = None) -> WordTable:
    """Return the candidates of the first search, the best first; at ``most`` some of them."""
    chosen = diagnosis.ranking[:most]
    title = "Candidates of the first search"
    if len(chosen) < len(diagnosis.ranking):
        title += f" (the best {len(chosen)} of {len(diagnosis.ranking)})"
    return WordTable(title, _RANK_HEAD, _ranked(diagnosis, chosen))


def refitted_table(diagnosis: Diagnosis) -> WordTable:
    """Return the factors on the model's poorly known values."""
    rows = tuple((value_words(path), parameter_text(p)) for path, p in diagnosis.refitted.items())
    head = ("value of the model", "refitted by the factor (95 % interval)")
    title = "Refitted with the effects" if diagnosis.confirmed else "Refitted values"
    return WordTable(title, head, rows)


def _size(size: float) -> str:
    return "< 0.01" if size < 0.01 else number(size, 2)


def _obstacles(diagnosis: Diagnosis, candidate: Candidate) -> str:
    """Return what is too small for a candidate to be named, or that it is ruled out or worse."""
    if candidate.name in {each.name for each in diagnosis.alternatives}:
        return "not distinguished"
    if small := too_small(candidate):
        return ", ".join(small)
    if candidate.name in diagnosis.ruled_out:
        return "ruled out"
    found = {each.name for each in diagnosis.effects}
    found |= {each.name for each in diagnosis.alternatives}
    best = max((each.score for each in diagnosis.ranking if each.name in found), default=None)
    worse = candidate.name not in found and best is not None and candidate.score < best
    return "lower score" if worse else NONE


def _ranked(diagnosis: Diagnosis, candidates: tuple[Candidate, ...]) -> Rows:
    return tuple(
        (
            candidate.name,
            number(candidate.score + 0.0, 1),
            number(candidate.threshold, 1),
            *(
                (
                    share(candidate.explained),
                    f"{_size(candidate.size)} × typical",
                    _obstacles(diagnosis, candidate),
                )
                if candidate.score > _NO_GAIN
                else (NONE, NONE, "score")
            ),
            "in full" if candidate.tried == "full" else "linearly",
        )
        for candidate in candidates
    )

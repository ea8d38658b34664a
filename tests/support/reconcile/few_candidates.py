"""Diagnoses that try few effects of the catalogue, which takes a fraction of the time."""

from hbench.model.effects.catalogue import EFFECTS


def try_only(monkeypatch, *names: str) -> None:
    """Let a diagnosis try these effects alone."""
    others = dict.fromkeys(set(EFFECTS) - set(names), "not in this test")
    place = "hbench.reconcile.diagnose.observable_effects"
    monkeypatch.setattr(place, lambda runs, plant: (names, others))

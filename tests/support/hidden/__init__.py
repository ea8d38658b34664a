"""Blind campaigns for reconcile: effects that the catalogue knows, in forms that it does not.

    python tests/support/hidden/generate.py OUT --cases small

writes the campaigns of ``small`` or ``all`` cases to ``OUT/NAME``, on all cores. Each is a campaign
folder as ``hbench run --plant`` makes it, of ``configs/discriminate.yaml`` unless ``--schedule``
names another. ``second.yaml`` is a plan on which no threshold is tuned. ``--csv index`` and
``--csv map`` also write the campaigns as logs of another bench (``foreign.py``). ``cases.py`` lists
the cases; ``truth(case)`` returns what was put in.

The plants differ from the model's in everything that a bench file knows badly (``draws.py``) and
vary from one pass of trials to the next. They have the small errors of every bench
(``background.py``): three valves with unequal gains and nulls, sensors within their class, ports
that are laminar at small drops, friction that varies along the bores and wanders from run to run.
The effects' laws (``laws/``) are loaded through ``HBENCH_EFFECTS``, so the process that generates
must not be the one that reconciles: import ``cases`` there, and nothing else.

Nothing here imports the catalogue's laws. Sizes were matched to the catalogue's typical ones by
what they do over the range in which this plan runs, except those of sensors, which lie beyond the
sensor's class; see ``sizes.py``.
"""

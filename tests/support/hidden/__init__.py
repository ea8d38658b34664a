"""Blind campaigns for reconcile: effects that the catalogue knows, in forms that it does not.

    python tests/support/hidden/generate.py OUT --cases small

writes the campaigns of ``small`` or ``all`` cases to ``OUT/NAME``, on all cores. Each is a campaign
folder as ``hbench run --plant`` makes it, of ``configs/discriminate.yaml`` unless ``--schedule``
names another. ``cases.py`` lists them, ``truth(case)`` tells what was put in.

The plants differ from the model's in everything that a bench file knows badly (``draws.py``), vary
from one pass of trials to the next, and have small errors that no row of the catalogue
describes. The effects' laws (``laws/``) are loaded through ``HBENCH_EFFECTS``, so the process that
generates must not be the one that reconciles: import ``cases`` there, and nothing else.

Nothing here imports the catalogue's laws. Sizes were matched to the catalogue's typical ones by
what they do over the range in which this plan runs, and are written down in ``sizes.py``.
"""

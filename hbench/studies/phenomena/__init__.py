"""Phenomena of friction (source, section 3.1), each a scripted simulation of the laws alone.

A file holds one of them: what is simulated, and the closed forms that its defining numbers are
compared with. Nothing but the friction laws is in them: a prescribed motion, or a mass that is
pushed or pulled. Studies that need the bench and its controllers are in ``studies/``.
"""

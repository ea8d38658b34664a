"""Phenomena of friction (source, section 3.1), each a scripted simulation of the laws alone.

Each file holds one phenomenon: its simulation, and the closed forms of its defining numbers. They
simulate the friction laws alone, under a prescribed motion or on a mass that is pushed or pulled.
Studies that need the bench and its controllers are in ``studies/``.
"""

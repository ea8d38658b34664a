"""Friction curves of each kind of experiment, and quantities derived from them."""

"""Friction curves of each kind of experiment, and what follows from them."""

"""Linearisation, transfer functions, PI loops, their figures of merit, and gains for a bench."""

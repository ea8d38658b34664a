"""Learned laws: tables fitted to the residuals that no effect of the catalogue explains."""

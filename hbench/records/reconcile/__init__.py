"""Records of `reconcile`: gaps, effects, what runs can tell apart, and the diagnosis."""

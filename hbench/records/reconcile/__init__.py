"""Records of `reconcile`: gaps, effects, effects that runs distinguish, and the diagnosis."""

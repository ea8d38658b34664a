"""Physical effects that a plant can have: the catalogue, and the law of each."""

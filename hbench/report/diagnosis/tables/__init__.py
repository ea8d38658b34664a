"""Tables of a diagnosis."""

"""Import of other benches' logs, by a default layout or an import map."""

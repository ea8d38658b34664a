"""Studies of the source document that are reproduced by simulation."""

"""Words of the diagnosis, by what they describe."""

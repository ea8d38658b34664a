"""Process pools and a Dask cluster: one function applied to many arguments."""

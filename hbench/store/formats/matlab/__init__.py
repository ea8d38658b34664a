"""MATLAB files: version 7 and earlier, and 7.3, which is HDF5."""

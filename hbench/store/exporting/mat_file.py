"""MATLAB files of version 5 that contain the same bytes for the same content."""

import io
from collections.abc import Mapping

import numpy as np

_TEXT = 116  # bytes of a file's description, which scipy fills with the time


def mat_file(content: Mapping[str, np.ndarray], compressed: bool = False) -> bytes:
    """Return a file of version 5 with the variables ``content``."""
    from scipy.io import savemat

    data = io.BytesIO()
    savemat(data, content, long_field_names=True, do_compression=compressed, oned_as="column")
    return b"MATLAB 5.0 MAT-file, written by hbench".ljust(_TEXT) + data.getvalue()[_TEXT:]

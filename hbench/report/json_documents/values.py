"""Values of Python and numpy as JSON values."""

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

# Documents consist mostly of these: a look at the type is faster than at base classes.
SCALARS = frozenset((bool, int, float, str, type(None)))


def json_value(value: Any) -> Any:
    """Return a value as JSON types; NaN and infinities become null."""
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if type(value) in SCALARS:
        return value
    if isinstance(value, Mapping):
        return {str(key): json_value(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return json_value(value.tolist())
    if isinstance(value, list | tuple):
        return [json_value(item) for item in value]
    return value if isinstance(value, bool | int | str) else str(value)


def json_text(document: Any) -> str:
    """Return the text of a document's JSON values."""
    return json.dumps(document, indent=1, allow_nan=False) + "\n"

"""Values as JSON represents them."""

import math
from typing import Any

import numpy as np


def plain(value: Any) -> Any:
    """Mappings, sequences and numbers, also NumPy's; numbers that are not finite are None."""
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, tuple | list):
        return [plain(entry) for entry in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value

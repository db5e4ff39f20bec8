"""Answers as JSON knows them."""

import math
from typing import Any


def plain(value: Any) -> Any:
    """Mappings, sequences and numbers; what is no finite number is None."""
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, tuple | list):
        return [plain(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value

"""What the tests of compiled kernels share: the head of a text, and others who execute it."""

from typing import Any

EXACT = 'OPTIONS = {"cache": False, "error_model": "numpy", "_nrt": False}'
HEAD = "import math\n\nimport numba\nimport numpy as np\n\n"


def plain(options: str, text: str) -> dict[str, Any]:
    """The names of a text that Python itself executes, whose functions numba compiles."""
    names: dict[str, Any] = {}
    exec(compile(f"{HEAD}{options}\n{text}", "plain", "exec"), names)
    return names


def python_only(text: str) -> dict[str, Any]:
    """The names of a text whose functions stay Python's."""
    kept = "\n".join(line for line in text.splitlines() if not line.startswith("@numba.njit"))
    names: dict[str, Any] = {}
    exec(compile(f"{HEAD}{kept}", "python", "exec"), names)
    return names

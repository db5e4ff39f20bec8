"""What numbers were measured with: the machine and the versions."""

import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from codegen import __version__

LIBRARIES = ("numba", "llvmlite", "numpy", "scipy", "sympy")


def environment() -> dict[str, str]:
    """Names → texts."""
    found = {
        "machine": _processor(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "linkwright": __version__,
    }
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _processor() -> str:
    information = Path("/proc/cpuinfo")
    if information.is_file():
        for line in information.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()

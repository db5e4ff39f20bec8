"""Memory that a result takes, known before its run, and the refusal of what does not fit."""

import os
from pathlib import Path

from codegen.errors import InputError
from runtime.mechanism.module_tables import Description

_NUMBER = 8  # layout: bytes of a number
_GIGABYTE = 1e9  # formula: bytes of a gigabyte
_SHARE = 0.9  # safety: of the memory that is free, which a result may take
_LIMITS = (
    ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),
    ("/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes"),
)
"""Files in which Linux keeps what a container may take, and what it has taken."""


def sample_bytes(description: Description) -> int:
    """Bytes of all quantities of a result at one instant."""
    n, switches = len(description.coordinates), len(description.switches)
    rows = len(description.constraints) + len(description.reactions) + len(description.powers)
    return _NUMBER * (3 * n + rows + 2 * switches + 5)


def state_bytes(description: Description) -> int:
    """Bytes of what the integration itself records at one instant."""
    return _NUMBER * (2 * len(description.coordinates) + len(description.switches) + 1)


def free_bytes() -> int | None:
    """Bytes that this process can still take; None where the system does not tell."""
    found = list[int]()
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        found += [int(row.split()[1]) << 10 for row in lines if row.startswith("MemAvailable:")]
    except (OSError, ValueError, IndexError):
        pass
    for limit, taken in _LIMITS:
        try:
            found.append(int(Path(limit).read_text()) - int(Path(taken).read_text()))
        except (OSError, ValueError):  # none, or "max"
            continue
    if not found and hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
        found.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return max(0, min(found)) if found else None


def require_memory(title: str, what: str, needed: int, advice: str) -> None:
    """Raise InputError where `what` takes more bytes than are free, with both numbers."""
    free = free_bytes()
    if free is not None and needed > _SHARE * free:
        raise InputError(
            f"{title}: {what} take {needed / _GIGABYTE:.3g} GB, and {free / _GIGABYTE:.3g} GB of "
            f"memory are free. {advice}"
        )

"""The programs of which the last bits of a run depend: versions, sources, processor."""

import hashlib
import platform
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path

from codegen import __version__
from codegen.errors import LinkwrightError

LIBRARIES = ("llvmlite", "numba", "numpy", "scipy")
SOURCES = "sources of Linkwright"
PROCESSOR = "processor"


@cache
def program_facts() -> dict[str, str]:
    """Versions by name, the hash of Linkwright's own sources, and the kind of processor."""
    from importlib import import_module

    binding = import_module("llvmlite.binding")  # which has no types

    return {
        "linkwright": __version__,
        SOURCES: sources_hash(),
        "python": platform.python_version(),
        **{library: version(library) for library in LIBRARIES},
        PROCESSOR: f"{platform.machine()} {binding.get_host_cpu_name()}",
    }


@cache
def sources_hash() -> str:
    """SHA-256 of the files of Python that this installation has of Linkwright."""
    root = Path(__file__).resolve().parents[2]
    found = hashlib.sha256()
    for package in ("codegen", "runtime"):
        for file in sorted((root / package).rglob("*.py")):
            content = file.read_bytes()
            found.update(f"{file.relative_to(root).as_posix()} {len(content)}\n".encode() + content)
    return found.hexdigest()


def changed_programs(before: Mapping[str, object]) -> Iterator[str]:
    """A clause for each program that was another one when facts were noted."""
    for name, now in program_facts().items():
        if before.get(name) == now:
            continue
        if name == SOURCES:
            yield f"the {SOURCES} have another text"
        else:
            yield f"{name} was {before.get(name, 'not noted')} and is {now}"


def require_programs(wanted: Mapping[str, object]) -> None:
    """Refuse to make runs by other programs than the sweep began with.

    The processor may differ, as that of a cluster's computers may.

    Raises
    ------
    LinkwrightError
        With all that differs.
    """
    changes = [x for x in changed_programs(wanted) if not x.startswith(PROCESSOR)]
    if changes:
        raise LinkwrightError(
            f"A worker on {platform.node() or 'another computer'} has other programs than the "
            f"sweep: {'; '.join(changes)}. Install the same ones there, and start it again."
        )

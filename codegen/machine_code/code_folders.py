"""Folders and files of machine code, named by all that it was made from: nothing in them is old.

The name has a hash of the sources, of the versions and of the processor. Whoever has another one
of these looks elsewhere, and a process that is killed while it writes leaves nothing that another
takes for whole.
"""

import hashlib
import os
import platform
import shutil
import sys
import tempfile
import threading
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite  # type: ignore[import-untyped]
import numba
from llvmlite import binding

_config: Any = numba.config  # which numba leaves untyped
_llvm: Any = binding

CHOSEN = str(_config.CACHE_DIR)
"""The folder that a user has chosen: NUMBA_CACHE_DIR."""

_KEPT = 4  # safety: states of one thing's sources whose machine code is kept, the newest
_noted: set[Path] = set()  # folders with a note
_deciding = threading.RLock()  # where numba keeps functions: all threads share its setting


class CacheWarning(UserWarning):
    """Machine code cannot be kept on the disk, and is compiled again by each process."""


@cache
def processor() -> tuple[str, str]:
    """Name and features of the processor that machine code is for, as numba has them."""
    name = _config.CPU_NAME or _llvm.get_host_cpu_name()
    if _config.CPU_FEATURES is not None:
        return name, _config.CPU_FEATURES
    try:
        features = _llvm.get_host_cpu_features()
    except RuntimeError:  # LLVM cannot tell
        return name, ""
    if not _config.ENABLE_AVX:
        features.update({key: False for key in features if key.startswith("avx")})
    return name, features.flatten()


@cache
def _surroundings() -> bytes:
    """All but the sources on which machine code depends, this package included."""
    here = sorted(Path(__file__).parent.glob("*.py"))
    settings = sorted(
        item for item in os.environ.items()
        if item[0].startswith("NUMBA_") and item[0] != "NUMBA_CACHE_DIR"
    )  # fmt: skip
    versions = (sys.version, numba.__version__, llvmlite.__version__, platform.machine())
    facts = repr((versions, processor(), settings, os.environ.get("LINKWRIGHT_NUMBA")))
    return b"".join([facts.encode(), *(path.read_bytes() for path in here)])


def name_of_state(sources: Iterable[bytes]) -> str:
    """A name for what is made from sources as they are, by these versions, for this processor."""
    digest = hashlib.sha256(_surroundings())
    for source in sources:
        digest.update(hashlib.sha256(source).digest())
    return digest.hexdigest()[:24]


def code_folder(beside: Path) -> Path | None:
    """The folder for machine code of the sources in a folder; None if none can be written.

    That is NUMBA_CACHE_DIR, or `__pycache__` beside the sources, or in the user's cache folder.
    """
    unique = unique_name(beside)
    places = [Path(CHOSEN) / unique] if CHOSEN else [beside / "__pycache__"]
    users = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or "~/.cache"
    for place in (*places, Path(users) / "linkwright" / unique):
        with suppress(OSError, RuntimeError):  # read-only, or a user without a home
            found = place.expanduser()
            found.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=found).close()
            return found
    note(beside, "kept nowhere, since no folder for it can be written")
    return None


def unique_name(folder: Path) -> str:
    """A name for a folder among all of the disk."""
    return f"{folder.name}_{hashlib.sha256(os.fsencode(folder.resolve())).hexdigest()[:24]}"


def remove_older(folder: Path, pattern: str) -> None:
    """Of files or folders that match, leave the newest."""
    with suppress(OSError):  # another process removes them as well
        found = sorted(folder.glob(pattern), key=lambda path: path.stat().st_mtime)
        for path in found[:-_KEPT]:
            shutil.rmtree(path) if path.is_dir() else path.unlink()


@contextmanager
def numba_keeps_in(folder: Path | None) -> Iterator[None]:
    """Within the block, functions that numba decorates are kept in this folder."""
    with _deciding:
        before, _config.CACHE_DIR = _config.CACHE_DIR, str(folder or "")
        try:
            yield
        finally:
            _config.CACHE_DIR = before


def note(folder: Path, what: str) -> None:
    """Warn, once for each folder."""
    if folder not in _noted:
        _noted.add(folder)
        warnings.warn(f"{folder}: machine code is {what}.", CacheWarning, stacklevel=2)

"""Folders and files of machine code, named by a hash of all sources, so that none is stale.

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
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite  # type: ignore[import-untyped]
import numba
from llvmlite import binding

from codegen.errors import note
from codegen.machine_code.undocumented_names import PLAIN, UserProvidedCacheLocator

_config: Any = numba.config  # which numba leaves untyped
_llvm: Any = binding

CHOSEN = str(_config.CACHE_DIR)
"""The folder that a user has chosen: NUMBA_CACHE_DIR."""

_ELSEWHERE = {"NUMBA_CACHE_DIR", "NUMBA_NUM_THREADS", "NUMBA_THREADING_LAYER"}
_KEPT = 4  # safety: newest versions of the sources whose machine code is kept
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
    """All but the sources on which machine code depends: not its folder, nor numba's threads."""
    here = sorted(Path(__file__).parent.glob("*.py"))
    settings = sorted(
        item for item in os.environ.items()
        if item[0].startswith("NUMBA_") and item[0] not in _ELSEWHERE
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


def code_folders(beside: Path, name: str = "") -> list[Path]:
    """Folders for machine code of the sources in a folder, to be read in this order.

    They are NUMBA_CACHE_DIR, or `__pycache__` beside the sources, and one in the user's cache
    folder. The first that can be written is the last; others are there if they have `name`: an
    administrator has compiled for all. Where none can be written, PLAIN has none at all.
    """
    unique, found = unique_name(beside), list[Path]()
    places = [Path(CHOSEN) / unique] if CHOSEN else [beside / "__pycache__"]
    for place in (*places, users_folder() / unique):
        with suppress(OSError, RuntimeError):  # a user without a home, or a folder without access
            folder = place.expanduser()
            if is_writable(folder):
                return [*found, folder]
            if name and (folder / name).exists() and not PLAIN:
                found.append(folder)
    return found


def users_folder() -> Path:
    """The folder in the user's cache folder, which may begin with ~."""
    users = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or "~/.cache"
    return Path(users) / "linkwright"


def is_writable(folder: Path) -> bool:
    """Whether a folder is there, or can be made, and files can be written into it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


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
        before = _config.CACHE_DIR, _config.CACHE_LOCATOR_CLASSES
        _config.CACHE_DIR = str(folder or "")
        if not PLAIN:
            _config.CACHE_LOCATOR_CLASSES = f"{__name__}.OwnFolder"
        try:
            yield
        finally:
            _config.CACHE_DIR, _config.CACHE_LOCATOR_CLASSES = before


class OwnFolder(UserProvidedCacheLocator):  # type: ignore[misc]
    """Numba's folder of a chosen name, which may be one that can be read alone."""

    def ensure_cache_path(self) -> None:
        """Make it, if that can be."""
        with suppress(OSError):
            Path(self.get_cache_path()).mkdir(parents=True, exist_ok=True)


@cache
def note_unkept() -> None:
    """Say, once, that machine code is kept nowhere, and the remedy; no error, whatever the filters.

    What was compiled is right, and runs.
    """
    note(
        "Machine code cannot be kept, so that each process compiles it again, for some 20 s: no "
        "folder for it can be written, or its disk is full. Set the environment variable "
        "NUMBA_CACHE_DIR to a folder that can be written, or have whoever installed Linkwright "
        "run `linkwright precompile`, once for all users.",
        CacheWarning,
    )

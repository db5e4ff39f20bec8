"""Files and folders that are written whole or not at all; where that fails, a message says why."""

import errno
import os
import shutil
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from codegen.errors import InputError
from codegen.termination_signals import SignalDeferral

_PREFIX = ".linkwright-"  # of the folder in which a file is written
_NEW = 60.0  # safety: s; an older folder counts as locked only if the process that made it lives
_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


@contextmanager
def whole_file(path: Path, kind: type[InputError] = InputError) -> Iterator[Path]:
    """The path at which to write the content of `path`, which replaces an older file at the end.

    A link stays one, and what it points to is replaced; an older file keeps its permissions.

    Raises an error of `kind` that names `path` and says what to do where it cannot be written. An
    OSError of the block about another file is none of these.
    """
    others: OSError | None = None
    try:
        path = path.resolve()
        mode = stat.S_IMODE(path.stat().st_mode) if path.exists() else 0o644
        with _locked_folder(path.parent) as folder:
            temporary = folder / path.name
            try:
                yield temporary
            except OSError as error:
                named = {str(x) for x in (error.filename, error.filename2) if x is not None}
                others = error if named and str(temporary) not in named else None
                raise
            with temporary.open("rb") as file:
                os.fsync(file.fileno())  # the name must not reach the disk before the content
            temporary.chmod(mode)  # whatever the umask: others read a new file as well
            temporary.replace(path)
    except OSError as error:
        if error is others:
            raise
        raise kind(_sentence(path, error)) from error


@contextmanager
def whole_folder(path: Path, mark: str, kind: type[InputError] = InputError) -> Iterator[Path]:
    """The path at which to write a folder, which replaces an older one at the end.

    Only a folder that has a file `mark` is replaced: another one may be anything of the user's.
    Between two renamings there is none at `path`; where a process dies there, the next one that
    writes into the same folder finishes.

    Raises an error of `kind` that names `path`, as `whole_file` does.
    """
    path = path.resolve()
    require_replaceable(path, mark, kind)
    try:
        with _locked_folder(path.parent) as folder:
            temporary, older = folder / "new" / path.name, folder / "old"
            temporary.parent.mkdir()
            yield temporary
            flush_folder(temporary)
            if path.exists():
                path.replace(older)
            try:
                temporary.replace(path)
            except OSError:
                if older.exists():
                    older.replace(path)
                raise
    except OSError as error:
        raise kind(_sentence(path, error)) from error


def flush_folder(folder: Path) -> None:
    """Have a file, or all those of a folder, on the disk before a name that leads to them is."""
    for file in (folder, *folder.rglob("*")):
        if file.is_file():
            with file.open("rb") as written:
                os.fsync(written.fileno())


def _lock(path: Path, timeout: float = -1) -> Any:
    from filelock import FileLock  # which takes a tenth of a start of the program

    return FileLock(path, timeout=timeout)


@contextmanager
def _locked_folder(place: Path) -> Iterator[Path]:
    """A temporary folder in `place` that is locked, signals deferred; leftovers are removed."""
    with (
        SignalDeferral(at_once=False),
        tempfile.TemporaryDirectory(prefix=_PREFIX, dir=place, ignore_cleanup_errors=True) as name,
        _lock(Path(name, ".lock")),
    ):
        _remove_leftovers(place)
        yield Path(name)


def require_replaceable(path: Path, mark: str, kind: type[InputError] = InputError) -> None:
    """Refuse a path at which something stands that `whole_folder` does not replace."""
    if path.exists() and not (path / mark).is_file():
        raise kind(f"{path} is there, and has no {mark}: it is left alone. Choose another name.")


def _sentence(path: Path, error: OSError) -> str:
    """Why a path cannot be written, and what to do."""
    folder, why = path.resolve().parent, f"cannot write {path}: {error.strerror or error}."
    if error.errno not in _FULL or not folder.is_dir():
        return f"{why} Choose another folder, or make this one writable."
    free = shutil.disk_usage(folder).free >> 10
    return (
        f"{why} There are {free} KiB free in {folder}: free some space, or choose a place on "
        "another disk. A file that had this name before is unchanged."
    )


def _remove_leftovers(folder: Path) -> None:
    """Remove what processes that were killed have left: folders that none has locked."""
    for left in folder.glob(f"{_PREFIX}*"):
        with suppress(OSError):
            if time.time() - left.stat().st_mtime > _NEW:
                with _lock(left / ".lock", timeout=0):
                    _finish_replacement(left)
                    shutil.rmtree(left, ignore_errors=True)


def _finish_replacement(left: Path) -> None:
    """Put a written folder in its place, where the older one was taken away and nothing is."""
    if (left / "old").exists():
        for written in (left / "new").iterdir():
            if not (place := left.parent / written.name).exists():
                written.replace(place)

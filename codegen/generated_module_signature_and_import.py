"""What a generated file is to its readers: how it is signed, checked, named and imported.

Both sides of the compiler use this module, the driver to compile a file that it has written and
the runtime to load one. It imports nothing of the compiler.
"""

import hashlib
import importlib.util
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType

from filelock import FileLock

from codegen.errors import GeneratedFileError, SupersededError

MARK = "# content-sha256: "
UNSIGNED = "0" * 64
_SIGNATURE = re.compile(rf"^{MARK}([0-9a-f]{{64}})$", re.MULTILINE)


def companion_path(path: Path, kind: str) -> Path:
    """The file that goes with a scene's generated file: its "tangents", or "reduced"."""
    return path.with_name(f"{path.stem}__{kind}.py")


def signed(text: str) -> str:
    """`text` with the hash of its content put where ``UNSIGNED`` stands."""
    digest = hashlib.sha256(text.encode()).hexdigest()
    return text.replace(MARK + UNSIGNED, MARK + digest, 1)


def is_signed(text: str) -> bool:
    """Whether a file's text carries a signature in its header, valid or not."""
    return _SIGNATURE.search(text[:4000]) is not None


def check_signature(path: Path, text: str, rebuild: str) -> None:
    """Compare the header's hash with the text's; GeneratedFileError if it is missing or differs."""
    match = _SIGNATURE.search(text[:4000])
    if match is None:
        raise GeneratedFileError(
            f"{path} has no content-sha256 line in its header, so it was not written by Linkwright "
            f"or was edited by hand. Delete it, or rebuild it: {rebuild}"
        )
    blank = text[: match.start(1)] + UNSIGNED + text[match.end(1) :]
    actual = hashlib.sha256(blank.encode()).hexdigest()
    if actual != match.group(1):
        raise GeneratedFileError(
            f"{path} was edited by hand, or cut short: its text hashes to {actual[:12]}..., its "
            f"header says {match.group(1)[:12]}.... Change the model, and rebuild: {rebuild}"
        )


def import_generated(path: Path, digest: str | None = None) -> ModuleType:
    """Import a generated file, compiling what numba's cache does not hold.

    The module's name follows from the file's content: numba's cache asks for it by name, in the
    process that compiled and in those that load, and a rebuilt module is never mistaken for the one
    that it replaces. Raises GeneratedFileError if the file cannot be read or does not compile,
    SupersededError if its text does not have the SHA-256 `digest`.
    """
    with alone(path):
        try:
            content = path.read_bytes()
        except OSError as error:
            raise GeneratedFileError(f"cannot read {path}: {error.strerror or error}.") from error
        actual = hashlib.sha256(content).hexdigest()
        if digest not in (None, actual):
            raise SupersededError(f"{path} was replaced while it was being loaded; load it again.")
        name = f"linkwright_generated_{path.stem}_{actual[:16]}"
        if name in sys.modules and sys.modules[name].__file__ == str(path):
            return sys.modules[name]
        return _execute(name, path)


def _execute(name: str, path: Path) -> ModuleType:
    loader = _ContentLoader(name, str(path))
    spec = importlib.util.spec_from_file_location(name, path, loader=loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise GeneratedFileError(
            f"{path} does not load: {type(error).__name__}: {error}. "
            "Delete it and load the model again to rebuild it."
        ) from error
    return module


@contextmanager
def alone(path: Path) -> Iterator[None]:
    """Only one process at a time compiles the numba functions of a file.

    Numba writes the index of a cache before its data: a process that reads between the two would
    take old machine code for new. The others wait, and find the cache filled. Where the folder
    cannot be written there is no cache beside the file, and no lock.
    """
    cache = path.parent / "__pycache__"
    try:
        cache.mkdir(exist_ok=True)
        lock = FileLock(cache / f"{path.stem}.lock")
        lock.acquire()
    except OSError:
        yield
        return
    try:
        yield
    finally:
        lock.release()


class _ContentLoader(SourceFileLoader):
    """Python's own loader, with byte code dated by the source's content instead of its clock.

    A module rebuilt within the same second with the same length must not meet old byte code.
    """

    def path_stats(self, path: str) -> dict[str, int]:
        """Size of the source and, in place of its time, 32 bits of its hash."""
        source = Path(path).read_bytes()
        stamp = int.from_bytes(hashlib.sha256(source).digest()[:4], "little")
        return {"mtime": stamp, "size": len(source)}

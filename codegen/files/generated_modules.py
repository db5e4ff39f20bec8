"""Generated files for their readers: signature, check, name and import.

Both sides of the compiler use this module, the driver to compile a file that it has written and
the runtime to load one. It imports nothing of the compiler.
"""

import contextlib
import hashlib
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from codegen.errors import GeneratedFileError
from codegen.machine_code.file_lock import locked

MARK = "# content-sha256: "
UNSIGNED = "0" * 64
_LONGEST = 100  # layout: bytes of a model's and of a scene's part of a file's name; disks take 255
# in the header, in the form that a checkout has without an installation
_REBUILD = re.compile(r"python -m codegen (\w+.*)")
_UNROLL = re.compile(r"\bunroll(?:=['\"]| )(always|never)\b")  # in the header's command
_HEADER = 4000  # layout: characters of a generated file, in which its command stands
_SIGNATURE = re.compile(rf"^{MARK}([0-9a-f]{{64}})$", re.MULTILINE)
_IMPORT = re.compile(r"^import numba$", re.MULTILINE)
_NAMES_PATHS = re.compile(r"^(?:#.*|SOURCES = (?:\(\n(?: .*\n)*\)|.*))\n", re.MULTILINE)
FIRST_KERNEL = re.compile(r"^(?:@|def )", re.MULTILINE)


def scene_path(folder: Path, model: str, scene: str, tail: str = "") -> Path:
    """The file ``model__scene.py`` of a scene."""
    return folder / f"{shortened(model)}__{shortened(scene)}{tail}.py"


def shortened(name: str) -> str:
    """The part of a file's name for a model or a scene: of a long one the beginning and a hash."""
    whole = os.fsencode(name)
    if len(whole) <= _LONGEST:
        return name
    beginning = whole[: _LONGEST - 9].decode(errors="ignore")
    return f"{beginning}_{hashlib.sha256(whole).hexdigest()[:8]}"


def companion_path(path: Path, kind: str) -> Path:
    """The file that goes with a scene's generated file: its "tangents", or "reduced"."""
    return path.with_name(f"{path.stem}__{kind}.py")


def signed(text: str) -> str:
    """`text` with the hash of its content put where ``UNSIGNED`` stands."""
    return text.replace(MARK + UNSIGNED, MARK + text_hash(text), 1)


def is_signed(text: str) -> bool:
    """Whether a file's text carries a signature in its header, valid or not."""
    return _SIGNATURE.search(text[:_HEADER]) is not None


def check_signature(path: Path, text: str, rebuild: str) -> None:
    """Compare the header's hash with the text's; GeneratedFileError if it is missing or differs."""
    match = _SIGNATURE.search(text[:_HEADER])
    if match is None:
        raise GeneratedFileError(
            f"{path} has no content-sha256 line in its header, so it was not written by Linkwright "
            f"or was edited by hand. Delete it, or rebuild it: {rebuild}"
        )
    blank = text[: match.start(1)] + UNSIGNED + text[match.end(1) :]
    actual = text_hash(blank)
    if actual != match.group(1):
        raise GeneratedFileError(
            f"{path} was edited by hand, or cut short: its text hashes to {actual[:12]}..., its "
            f"header says {match.group(1)[:12]}.... Change the model, and rebuild: {rebuild}"
        )


def read_generated(path: Path) -> str:
    """The text of a generated file, whatever line ends version control has given it.

    Raises GeneratedFileError if the file cannot be read.
    """
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise GeneratedFileError(f"cannot read {path}: {error.strerror or error}.") from error
    except UnicodeDecodeError as error:
        raise GeneratedFileError(
            f"{path} is damaged ({error}). Delete it and load the model again to rebuild it."
        ) from error


def unroll_of(text: str) -> str:
    """How kernels were written when a generated text was built."""
    match = _UNROLL.search(text[:_HEADER])
    return match[1] if match else "auto"


def text_hash(text: str) -> str:
    """SHA-256 of a generated text."""
    return hashlib.sha256(text.encode()).hexdigest()


def content_hash(text: str) -> str:
    """SHA-256 of what a generated text computes, whatever folder it was built from.

    That is the text without the comments of its header and without SOURCES, which name paths.
    """
    head = FIRST_KERNEL.split(text, maxsplit=1)[0]
    return text_hash(_NAMES_PATHS.sub("", head) + text[len(head) :])


def import_generated(path: Path, text: str | None = None) -> ModuleType:
    """Import a generated file, or its `text`, compiling kernels whose machine code is not kept.

    The module's name follows from the file's content: a rebuilt module is never mistaken for the
    one that it replaces. Raises GeneratedFileError if the file cannot be read or does not compile.
    """
    with alone(path):
        text = read_generated(path) if text is None else text
        name = f"linkwright_generated_{path.stem}_{text_hash(text)}"
        loaded: Any = sys.modules.get(name)
        if loaded is not None and loaded.__loader__.path == str(path):
            return loaded  # type: ignore[no-any-return]
        return _execute(name, path, text)


def _execute(name: str, path: Path, text: str) -> ModuleType:
    """Execute a verified text as a module that names no file: nothing reloads it by its date."""
    module = sys.modules[name] = ModuleType(name)
    vars(module)["__loader__"] = source = _Text(str(path), text)
    try:
        source.execute(vars(module))
    except BaseException as error:
        del sys.modules[name]
        if not isinstance(error, Exception):
            raise
        command = _REBUILD.search(text[:_HEADER])
        raise GeneratedFileError(
            f"{path} does not load: {type(error).__name__}: {error}. Delete it, and rebuild it: "
            f"{f'linkwright {command[1]}' if command else 'load the model again.'}"
        ) from error
    return module


@contextmanager
def alone(path: Path) -> Iterator[None]:
    """Only one process at a time compiles the numba functions of a file: the others wait for it.

    Where the folder cannot be written there is no cache beside the file, and no lock.
    """
    cache = path.parent / "__pycache__"
    with contextlib.suppress(OSError):
        cache.mkdir(exist_ok=True)
    with locked(cache / f"{path.stem}.lock"):
        yield


class _Text(NamedTuple):
    """The text of a module, in the place of its loader: tracebacks ask it for lines."""

    path: str
    text: str

    def execute(self, names: dict[str, Any]) -> None:
        """Execute it in these names, which have its own `numba`, and compile its kernels."""
        from codegen.machine_code.kernels import execute

        text = _IMPORT.sub("", self.text, count=1)
        code = compile(text, self.path, "exec", dont_inherit=True)
        execute(Path(self.path), self.text, names, lambda: exec(code, names))

    def get_source(self, name: str) -> str:
        """The text."""
        return self.text

    def pickled(self, kernel: str) -> tuple[Any, ...]:
        """How another process finds a kernel of the text."""
        return _kernel, (Path(self.path), self.text, kernel)


def _kernel(path: Path, text: str, name: str) -> Any:
    return getattr(import_generated(path, text), name)

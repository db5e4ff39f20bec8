"""Generated files: the report of each, with its counts and times, writing and compiling them."""

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

from codegen.emit.runge_kutta import module_text
from codegen.errors import GeneratedFileError
from codegen.files.generated_modules import alone, import_generated, text_hash
from codegen.files.library_folders import methods_folder
from codegen.files.whole_files import whole_file
from codegen.readers.calls import readable_class
from codegen.tableaus import tableaus

Progress = Callable[[str], None]


@dataclass
class Clock:
    """Times the stages of one scene, and announces them."""

    seconds: dict[str, float]  # stage → wall time; the latest is the last
    progress: Progress
    title: str  # model and scene, for the announcements

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Time the block."""
        self.progress(f"{self.title}: {stage}")
        started = perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.pop(stage, 0.0) + perf_counter() - started


@dataclass(kw_only=True)
class FileReport:
    """A generated file.

    Attributes
    ----------
    path, text, digest, changed
        The file, its text, the SHA-256 of that, and whether it is new, or in a check differs.
    operations
        Kernel → arithmetic operations.
    seconds
        Stage → wall time.
    """

    path: Path
    text: str = field(repr=False)
    digest: str = field(init=False)
    changed: bool = False
    operations: dict[str, int]
    seconds: dict[str, float]

    def __post_init__(self) -> None:
        self.digest = text_hash(self.text)

    def bring_up_to_date(self, check: bool) -> None:
        """Write the file unless it is current or this is a check; note whether it was stale."""
        stale = not is_current(self.path, self.text)
        self.changed = stale if check else write_if_changed(self.path, self.text)


@dataclass(kw_only=True)
class CompanionReport(FileReport):
    """A companion module; `title` is its content, for people."""

    title: str


@dataclass(kw_only=True)
class SceneReport(FileReport):
    """The files of one scene.

    Attributes
    ----------
    tangents, reduced, picture, outputs
        Its companion modules, if it has them: exact derivatives, reduced coordinates, geometry …
    notes
        Remarks for the modeller: constraints that are redundant near the start values; a
        start that is far from its guesses, where the scene was compiled.
    problem
        Why a scene that was compiled does not assemble; other parameters or guesses may.
    """

    model: str
    scene: str
    bodies: tuple[str, ...]
    coordinates: int
    constraints: int
    degrees_of_freedom: int
    states: tuple[str, ...]
    effects: tuple[str, ...]
    left_out: tuple[str, ...]
    strategy: str | None
    tangents: CompanionReport | None = None
    reduced: CompanionReport | None = None
    picture: CompanionReport | None = None
    outputs: CompanionReport | None = None
    notes: tuple[str, ...] = ()
    problem: str = ""

    @property
    def companions(self) -> tuple[CompanionReport, ...]:
        """Its companion modules."""
        return tuple(filter(None, (self.tangents, self.reduced, self.picture, self.outputs)))


@readable_class
@dataclass(frozen=True)
class BuildReport:
    """The result of `build`; `stale` lists the files that a check found out of date."""

    scenes: tuple[SceneReport, ...]
    stale: tuple[Path, ...] = ()

    @property
    def paths(self) -> tuple[Path, ...]:
        """The generated files."""
        return tuple(scene.path for scene in self.scenes)


def compile_modules(paths: Sequence[Path]) -> list[float]:
    """Compile and keep the kernels of each file; returns the seconds that each took."""
    seconds = []
    for path in paths:
        started = perf_counter()
        import_generated(path)
        seconds.append(perf_counter() - started)
    return seconds


class Written(NamedTuple):
    """The files of a folder, and those among them that were missing, old, or of nothing."""

    paths: tuple[Path, ...]
    stale: tuple[Path, ...]


def write_folder(
    folder: Path, texts: Mapping[str, str], *, others: str = "", check: bool = False
) -> Written:
    """Write texts by name into a folder, those that are not there; unless `check`, write nothing.

    Files that match the pattern `others` and have no text count as stale, and are left alone.
    Raises GeneratedFileError if the folder cannot be created or written, or if Python has taken
    away the docstrings that such texts hold.
    """
    if sys.flags.optimize > 1:
        raise GeneratedFileError(
            f"The files of {folder} hold docstrings of the source, which python -OO takes away. "
            "Write them with python, without -OO and PYTHONOPTIMIZE=2."
        )
    files = {folder / name: text for name, text in texts.items()}
    stale = [path for path, text in files.items() if not is_current(path, text)]
    for path in () if check else stale:
        write_if_changed(path, files[path])
    stale += sorted(path for path in folder.glob(others) if path not in files) if others else []
    return Written(tuple(files), tuple(stale))


def write_if_changed(path: Path, text: str) -> bool:
    """Write `text` to `path`, whole or not at all; False if the file holds it already.

    Two builds of the same model write the same bytes, so the later rename changes nothing. Raises
    GeneratedFileError if the folder cannot be created or written.
    """
    try:
        if is_current(path, text):
            return False
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise GeneratedFileError(
            f"cannot write {path}: {error.strerror or error}; choose another folder with --out, "
            "or make this one writable."
        ) from error
    with (
        alone(path) if path.suffix == ".py" else nullcontext(),
        whole_file(path, GeneratedFileError) as temporary,
    ):
        temporary.write_bytes(text.encode())
    return True


def is_current(path: Path, text: str) -> bool:
    """Whether `path` holds `text`, with the line ends of any system."""
    return path.is_file() and path.read_text(encoding="utf-8", errors="replace") == text


def write_methods(folder: Path | None = None, *, check: bool = False) -> Written:
    """Write one module a tableau into the library's folder, or into another; as `write_folder`."""
    folder = folder or methods_folder()
    texts = {f"{name}.py": module_text(name, tableau) for name, tableau in tableaus().items()}
    return write_folder(folder, texts, others="[!_]*.py", check=check)

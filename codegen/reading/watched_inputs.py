"""What a model asks for while its file runs: files, folders, variables of the environment.

Python's audit events tell what is opened, listed and imported, as far as the model's own files or
another thread ask for it, however deep: not what a package opens that is being imported. Nobody can
watch other programs and computers, clocks, chance, and libraries that open files by themselves.
"""

import ast
import inspect
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import FrameType
from typing import Any

from codegen.files.build_records import Input, value_of
from codegen.files.library_folders import LIBRARY, is_installed

_PLACES = {
    "open": ("file", 0), "import": ("file", 1), "sqlite3.connect": ("file", 0),
    "os.listdir": ("folder", 0), "os.scandir": ("folder", 0),
}  # fmt: skip
"""Audit events → what they ask for, and which of their arguments names it."""
_ELSEWHERE = ("socket.", "subprocess.", "urllib.", "os.system", "os.exec", "os.fork", "os.spawn",
              "os.posix_spawn", "builtins.input")  # fmt: skip
"""Beginnings of audit events: other programs and computers are asked."""
_UNSEEN = {
    *("time", "time_ns", "now", "today", "utcnow", "localtime", "gmtime", "perf_counter"),
    *("monotonic", "urandom", "uuid1", "uuid4", "randbits", "token_hex", "token_bytes"),
    *("strftime", "ctime", "asctime", "parse_args", "parse_known_args"),
    *("getpid", "gethostname", "cpu_count", "exists", "is_file", "is_dir", "isfile", "isdir"),
    *("stat", "getmtime", "getsize", "access", "open_dataset", "load_dataset", "Dataset"),
    *("read_parquet", "read_feather", "read_hdf", "read_orc", "read_table"),
}
"""Functions by the last part of their names: clocks, chance, looks at files without opening."""
_GENERATORS = {"default_rng", "Random", "RandomState", "SystemRandom", "seed", "SeedSequence"}
"""Functions that begin a sequence of random numbers, the same one where they are given a seed."""
_RANDOM = {"random", "numpy.random", "secrets"}

_watching: list["Watch"] = []


class Watch:
    """The requests of a model file and of those that it reads."""

    def __init__(self) -> None:
        self.asked: dict[tuple[Any, str], None] = {}
        self.unwatched: dict[str, None] = {}

    def hear(self, event: str, given: tuple[Any, ...]) -> None:
        """Note an audit event."""
        if event == "import" and given[1] is None:  # by its name
            for folder in filter(_is_local_folder, given[2]):
                self.note("module", str(Path(folder, *given[0].split("."))))
        elif event in _PLACES:
            kind, place = _PLACES[event]
            self.note(kind, "." if kind == "folder" and given[place] is None else given[place])
        elif event.startswith(_ELSEWHERE) and (asker := _asker()):
            self.unwatched[f"{event}, {asker}"] = None

    def note(self, kind: str, name: Any) -> None:
        """Note a request for a file, a folder or a variable, if it is the model's."""
        if not isinstance(name, str | bytes | os.PathLike) or not _asker(kind):
            return
        text = os.fsdecode(name)
        if kind != "variable":
            if not os.path.isabs(text):  # noqa: PTH117
                self.asked["working folder", ""] = None
            text = os.path.abspath(text)  # noqa: PTH100 (links stay, and `..` goes)
            own = any(part in text for part in ("__pycache__", ".linkwright-"))
            if own or not is_local(text):
                return
        self.asked[kind, text] = None

    def inputs(self) -> tuple[Input, ...]:
        """All that was asked for, with the hashes of what was given, and is not yet changed."""
        return tuple(Input(kind, name, value_of(kind, name)) for kind, name in self.asked)


@contextmanager
def watched() -> Iterator[Watch]:
    """Watch what is asked for in the block."""
    _listen()
    watch, environment = Watch(), vars(os.environ)
    usual = {word: environment[word] for word in ("encodekey", "decodekey")}

    def look_up(name: str) -> Any:
        watch.note("variable", name)
        return usual["encodekey"](name)

    def list_name(name: Any) -> Any:
        watch.note("variable", "")
        return usual["decodekey"](name)

    _watching.append(watch)
    environment.update(encodekey=look_up, decodekey=list_name)
    try:
        yield watch
    finally:
        environment.update(usual)
        _watching.remove(watch)


@cache
def _listen() -> None:
    """Hear audit events from now on: a hook stays as long as the process."""

    def hear(event: str, given: tuple[Any, ...]) -> None:
        for watch in _watching:
            watch.hear(event, given)

    sys.addaudithook(hear)


def is_local(file: str) -> bool:
    """Whether code is in a file of the user or of a model, none of a package, and no text alone."""
    return not file.startswith("<") and _is_local_folder(os.path.dirname(file))  # noqa: PTH120


@cache
def _is_local_folder(name: str) -> bool:
    ours = (LIBRARY / name for name in ("linkwright", "codegen", "runtime", "generated"))
    folder = Path(name).resolve()
    return not (is_installed(folder) or any(map(folder.is_relative_to, ours)))


def _asker(kind: str = "") -> str:
    """The user's own line that asks, or another thread; empty for a package that is imported."""
    frame: FrameType | None = inspect.currentframe()
    while frame is not None and frame.f_globals.get("__name__") == __name__:
        frame = frame.f_back
    if kind == "folder" and frame is not None and "importlib" in frame.f_code.co_filename:
        return ""  # a search for a module
    while frame is not None:
        code = frame.f_code
        if is_local(code.co_filename):
            return f"{Path(code.co_filename).name}, line {frame.f_lineno}"
        if code.co_name == "<module>" and not code.co_filename.startswith("<"):
            return ""
        frame = frame.f_back
    return "another thread"


def unseen_requests(files: Iterable[Path]) -> Iterator[str]:
    """What Python files ask for, unless as programs of their own, that nobody can watch."""
    unseen = {"argv"} | {x for x in [*sys.modules] if not getattr(sys.modules[x], "__spec__", 0)}
    for file in files:
        tree = ast.parse(file.read_bytes())
        tree.body = [x for x in tree.body if not ast.unparse(x).startswith("if __name__ ")]
        nodes: list[Any] = [*ast.walk(tree)]
        drawn = {
            x.asname or x.name for n in nodes if getattr(n, "module", 0) in _RANDOM for x in n.names
        }  # fmt: skip
        names = [(getattr(x, k, 0), x) for x in nodes for k in ("attr", "module", "name")]
        yield from (f"{name}, {file.name}, line {x.lineno}" for name, x in names if name in unseen)
        calls = [node for node in nodes if isinstance(node, ast.Call)]
        named = [(ast.unparse(call.func).split("."), call) for call in calls]
        seeded = any(parts[-1] == "seed" and call.args for parts, call in named)
        for parts, call in named:
            last, begins, of_object = parts[-1], parts[-1] in _GENERATORS, "(" in "".join(parts)
            chance = last in drawn or ("random" in parts[:-1] and not of_object)
            if (
                last in _UNSEEN
                or parts[0] == "h5py"
                or (begins and not call.args and not call.keywords)
                or (chance and not begins and not seeded)
            ):
                yield f"{'.'.join(parts)}, {file.name}, line {call.lineno}"

"""The inputs that a model file reads as it runs: files, folders, variables of the environment.

Python's audit events tell what is opened, listed and imported, as far as the model's own files or
another thread ask for it, however deep: not what a package opens that is being imported. Nobody can
watch other programs and computers, clocks, chance, and libraries that open files by themselves.
"""

import ast
import inspect
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache, partial
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
    *("time", "now", "today", "utcnow", "urandom", "uuid", "secrets", "argv", "argparse", "getpid"),
    *("gethostname", "platform", "cpu_count", "exists", "is_file", "is_dir", "isfile", "isdir"),
    *("stat", "getmtime", "getsize", "access", "h5py", "netCDF4", "open_dataset", "load_dataset"),
    *("read_parquet", "read_feather", "read_hdf", "read_orc", "read_table", "load_result"),
}
"""Names of modules and functions: clocks, arguments, looks at files, and files that C opens."""
_RANDOM = {"random", "numpy.random"}
_GENERATORS = {"default_rng", "Random", "RandomState", "SystemRandom", "seed", "SeedSequence"}
"""Functions that begin a sequence of random numbers, the same one where they are given a seed."""

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
                stem = Path(folder, *given[0].split("."))
                self.note("file", f"{stem}.py")
                self.note("file", stem / "__init__.py")
        elif event == "open" and str(given[1]).startswith(("w", "a", "x")):
            pass  # it writes the file itself
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
        if text == ":memory:":  # no file of SQLite's
            return
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
    watch = Watch()

    def look_up(encode: Callable[[Any], Any], name: Any) -> Any:
        watch.note("variable", name)
        return encode(name)

    def list_name(decode: Callable[[Any], Any], name: Any) -> Any:
        watch.note("variable", "")
        return decode(name)

    environments = [vars(os.environ), vars(getattr(os, "environb", os.environ))]
    usual = [dict(one) for one in environments]
    for one, before in zip(environments, usual, strict=True):
        one["encodekey"] = partial(look_up, before["encodekey"])
        one["decodekey"] = partial(list_name, before["decodekey"])
    _watching.append(watch)
    try:
        yield watch
    finally:
        _watching.remove(watch)
        for one, before in zip(environments, usual, strict=True):
            one.update(before)


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
    """What Python files name, unless as programs of their own, that nobody can watch.

    Random numbers are the same ones where every generator of a file is given a seed.
    """
    in_memory = {x for x in [*sys.modules] if not getattr(sys.modules[x], "__spec__", None)}
    for file in files:
        tree = ast.parse(file.read_bytes())
        tree.body = [x for x in tree.body if not ast.unparse(x).startswith("if __name__ ")]
        nodes: list[Any] = [*ast.walk(tree)]
        calls = [node for node in nodes if isinstance(node, ast.Call)]
        begun = [x for x in calls if ast.unparse(x.func).rpartition(".")[2] in _GENERATORS]
        seeded = begun and all(call.args or call.keywords for call in begun)
        unseen = _UNSEEN | in_memory | (set() if seeded else _RANDOM)
        for node in nodes:
            named = {getattr(node, part, None) for part in ("attr", "module", "name")}
            yield from (f"{name}, {file.name}, line {node.lineno}" for name in named & unseen)

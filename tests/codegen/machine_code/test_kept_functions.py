"""Compiled functions of the runtime: an edit of one, or of one that it calls, is always seen."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = """
import sys
from codegen.machine_code import compiled_functions
if sys.argv[1:] == ["killed"]:  # between numba's index and its data
    import os
    from numba.core.caching import IndexDataCacheFile
    IndexDataCacheFile._save_data = lambda *_: os._exit(9)
import runtime.linalg.doubling as module
print(module.twice(3.0), sum(module.twice.stats.cache_hits.values()))
"""
FUNCTIONS = """
from numba import types

from runtime.core.jit import compiled, inner
from runtime.linalg.factor import times


@compiled(types.float64(types.float64))
def twice(x):
    return times(x)
"""
CALLED = """
from runtime.core.jit import inner


@inner
def times(x):
    return {factor} * x
"""


@pytest.fixture
def library(root: Path, tmp_path: Path) -> Path:
    """A copy of the library, with a function that calls another one of another file."""
    place = tmp_path / "library"
    for package in ("codegen", "runtime", "generated/methods"):
        no_caches = shutil.ignore_patterns("__pycache__")
        shutil.copytree(root / package, place / package, ignore=no_caches)
    rooms = place / "runtime" / "linalg"
    (rooms / "doubling.py").write_text(FUNCTIONS)
    (rooms / "factor.py").write_text(CALLED.format(factor=2.0))
    return place


def run(library: Path, *words: str, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *words], cwd=library.parent, capture_output=True, text=True,
        env={**os.environ, "PYTHONPATH": str(library), **environment}, check=False,
    )  # fmt: skip
    assert done.returncode == (9 if words else 0), done.stderr
    return done.stdout


def edit(library: Path, factor: float) -> None:
    """Another text of the same size, its date set back to one that no byte code has."""
    path = library / "runtime" / "linalg" / "factor.py"
    path.write_text(CALLED.format(factor=factor))
    os.utime(path, (1e9 - factor, 1e9 - factor))


def test_an_edit_is_seen_also_after_a_kill(library: Path) -> None:
    edit(library, 2.0)
    assert [run(library), run(library)] == ["6.0 0\n", "6.0 1\n"]
    edit(library, 4.0)
    assert run(library, "killed") == ""
    assert [run(library), run(library)] == ["12.0 0\n", "12.0 1\n"]
    edit(library, 2.0)
    assert run(library) == "6.0 1\n"


def test_a_file_that_is_cut_short_is_made_anew(library: Path) -> None:
    run(library)
    for ending in ("nbi", "nbc"):
        (file,) = (library / "runtime" / "__pycache__").rglob(f"doubling.twice*.{ending}")
        file.write_bytes(file.read_bytes()[:100])
        assert [run(library), run(library)] == ["6.0 0\n", "6.0 1\n"]


def test_a_library_that_cannot_be_written_is_kept_for_the_user(library: Path) -> None:
    (library / "runtime" / "__pycache__").unlink(missing_ok=True)
    (library / "runtime" / "__pycache__").write_text("no folder")
    for folder in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        place = library.parent / folder
        given = {folder: str(place), "PYTHONDONTWRITEBYTECODE": "1"}
        assert [run(library, **given), run(library, **given)] == ["6.0 0\n", "6.0 1\n"]
        assert [*place.rglob("doubling.twice*.nbc")]


CLOSURES = """
import math, sys
from numba import types
from runtime.core.jit import closure, compiled

def make(factor):
    @closure
    def work(x, n):
        if n <= 0:
            return 0.0
        return factor * x + work(x, n - 1) * math.sin(0 * work(x, n - 2)) + 0 * work(x, n - 3)
    return work
"""
CALLER = """
from numba import types
from closures import make
from runtime.core.jit import compiled

work = make({factor})


@compiled(types.float64(types.float64))
def {name}(x):
    return work(x, 2)
"""
NAMED = """
import sys
for name in sys.argv[1:]: print(getattr(__import__(name), name)(1.0), flush=True)
"""
COPIES = """
import os, sys
from codegen.machine_code import compiled_functions
for name in sys.argv[1:]:
    if not (copy := os.fork()):
        print(getattr(__import__(name), name)(1.0), flush=True)
        os._exit(0)
    os.waitpid(copy, 0)
"""


@pytest.mark.parametrize(
    "runs",
    [[(NAMED, ["doubled"]), (NAMED, ["tripled"])], [(COPIES, ["doubled", "tripled"])]],
    ids=["two processes", "two copies of a process"],
)
def test_closures_of_two_processes_are_told_apart(
    tmp_path: Path, root: Path, runs: list[tuple[str, list[str]]]
) -> None:
    """Each has the first number of its process, and the linker took one of them for both."""
    (tmp_path / "closures.py").write_text(CLOSURES)
    for name, factor in (("doubled", 2.0), ("tripled", 3.0)):
        (tmp_path / f"{name}.py").write_text(CALLER.format(name=name, factor=factor))
    path = os.pathsep.join((str(tmp_path), str(root)))
    given = {**os.environ, "PYTHONPATH": path, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    texts = [
        subprocess.run([sys.executable, "-c", program, *names], env=given, check=True, text=True,
                       stdout=subprocess.PIPE).stdout
        for program, names in (*runs, (NAMED, ["doubled", "tripled"]))
    ]  # fmt: skip
    assert "".join(texts) == "2.0\n3.0\n" * 2

"""Several processes that use one cache of machine code, at once or one after the other."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

import pytest

from codegen import numba_cache
from codegen.numba_cache import checked_caches

ROOT = Path(__file__).parents[2]

# A closure that LLVM does not copy into its caller, as it does not copy the loop of a Newton
# iteration: its symbol is a weak one of each object file.
CLOSURES = """import math
import numba


def make(factor):
    @numba.njit("f8(f8,i8)", _nrt=False)
    def work(x, n):
        if n <= 0:
            return 0.0
        return factor * x + work(x, n - 1) * math.sin(0 * work(x, n - 2)) + 0 * work(x, n - 3)

    return work
"""
CALLER = """import numba
from closures import make

work = make({factor})


@numba.njit("f8(f8)", cache=True)
def {name}(x):
    return work(x, 2)
"""
PRINTED = """
from codegen.numba_cache import checked_caches
with checked_caches():
    for name in {names}:
        function = getattr(__import__(name), name)
        print(name, function(1.0), sum(function.stats.cache_hits.values()))
"""


def _process(code: str, folder: Path, *more: str) -> "subprocess.Popen[str]":
    """A process that runs `code`, whose warnings are part of what it prints."""
    path = os.pathsep.join((str(folder), str(ROOT)))
    return subprocess.Popen(
        [sys.executable, "-c", code, *more],
        env={**os.environ, "PYTHONPATH": path, "NUMBA_CACHE_DIR": str(folder / "cache")},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def _output(*processes: "subprocess.Popen[str]") -> list[str]:
    texts = [process.communicate()[0] for process in processes]
    assert [process.returncode for process in processes] == [0] * len(texts), "\n".join(texts)
    return texts


def test_closures_of_two_processes_are_told_apart(tmp_path: Path) -> None:
    """Each has the first number of its process, and the linker took one of them for both."""
    (tmp_path / "closures.py").write_text(CLOSURES)
    factors = {"doubled": 2.0, "tripled": 3.0}
    for name, factor in factors.items():
        (tmp_path / f"{name}.py").write_text(CALLER.format(name=name, factor=factor))
    texts = _output(*[_process(PRINTED.format(names=[name]), tmp_path) for name in factors])
    assert texts == ["doubled 2.0 0\n", "tripled 3.0 0\n"]
    (both,) = _output(_process(PRINTED.format(names=list(factors)), tmp_path))
    assert both == "doubled 2.0 1\ntripled 3.0 1\n"


def test_a_copy_of_a_process_numbers_functions_as_no_other() -> None:
    read, write = os.pipe()
    if not (child := os.fork()):
        os.write(write, str(next(numba_cache._Identity._unique_ids)).encode())
        os._exit(0)
    os.waitpid(child, 0)
    of_child, mine = int(os.read(read, 100)), next(numba_cache._Identity._unique_ids)
    assert of_child >> 32 != mine >> 32
    os.close(read)
    os.close(write)


TEXT = """import numba


@numba.njit("f8(f8)", cache=True)
def scaled(x):
    return {factor} * x
"""


def _execute(path: Path) -> float:
    module = sys.modules["scaled"] = ModuleType("scaled")
    module.__file__ = str(path)
    with checked_caches():
        exec(compile(path.read_text(), path, "exec"), vars(module))
    return float(module.scaled(1.0))


def test_a_reader_between_two_files_of_a_writer_finds_nothing_damaged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever file has been written last, another process may read the cache just then."""
    path = tmp_path / "scaled.py"
    numba_cache._noted.clear()
    usual, answers, reading = numba_cache._IndexLast._open_for_write, [], []

    @contextmanager
    def watched(files: object, name: str) -> Iterator[object]:
        with usual(files, name) as file:
            yield file
        if not reading:
            reading.append(name)
            answers.append(_execute(path))
            reading.clear()

    monkeypatch.setattr(numba_cache._IndexLast, "_open_for_write", watched)
    try:
        for factor in (2.0, 3.0, 4.0):
            path.write_text(TEXT.format(factor=factor))
            answers.clear()
            assert _execute(path) == factor
            assert answers == [factor, factor]
        assert not numba_cache._noted
    finally:
        sys.modules.pop("scaled", None)


# Each round is a new source, as a new name of the module says, which all processes compile at once,
# without a lock.
ROUNDS = """
import sys
from types import ModuleType
from codegen.numba_cache import checked_caches
text, path = sys.argv[1:]
for k in range(10):
    name = f"scaled{k}"
    module = sys.modules[name] = ModuleType(name)
    module.__file__ = path
    with checked_caches():
        exec(compile(text.format(factor=float(k)), path, "exec"), vars(module))
    assert module.scaled(1.0) == k, (module.scaled(1.0), k)
"""


def test_processes_that_write_one_cache_without_a_lock_disturb_none(tmp_path: Path) -> None:
    path = tmp_path / "scaled.py"
    path.write_text(TEXT)
    processes = [_process(ROUNDS, tmp_path, TEXT, str(path)) for _ in range(2)]
    assert _output(*processes) == ["", ""]


RUNTIME = """
import sys
from pathlib import Path
from codegen.files.generated_modules import import_generated
import runtime.core.dense_output
print(import_generated(Path(sys.argv[1])).scaled(1.0))
"""


def test_processes_compile_one_module_and_the_runtime_at_once(tmp_path: Path) -> None:
    path = tmp_path / "scaled.py"
    path.write_text(TEXT.format(factor=2.0))
    processes = [_process(RUNTIME, tmp_path, str(path)) for _ in range(2)]
    assert _output(*processes) == ["2.0\n", "2.0\n"]

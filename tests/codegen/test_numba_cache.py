"""Machine code on the disk that is damaged, old or cannot be kept is compiled anew, with a note."""

import os
import resource
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from codegen import numba_cache
from codegen.files.generated_modules import _TextLoader, import_generated
from codegen.numba_cache import CacheWarning, checked_caches

TEXT = """import numba


@numba.njit("f8(f8)", cache=True)
def scaled(x):
    return {factor} * x
"""


@pytest.fixture
def source(tmp_path: Path) -> Iterator[Path]:
    path = tmp_path / "scaled.py"
    path.write_text(TEXT.format(factor=2.0))
    _execute(path)
    yield path
    sys.modules.pop("scaled", None)


def _execute(path: Path) -> ModuleType:
    """As `import_generated`, of a module that numba finds by its name when it loads its code."""
    numba_cache._noted.clear()
    module = sys.modules["scaled"] = ModuleType("scaled")
    module.__file__ = str(path)
    code = _TextLoader("scaled", str(path), path.read_text()).get_code("scaled")
    with checked_caches():
        exec(code, vars(module))
    return module


def _hits(module: ModuleType) -> int:
    return sum(module.scaled.stats.cache_hits.values())


def test_an_undamaged_cache_is_taken(source: Path) -> None:
    module = _execute(source)
    assert (module.scaled(1.0), _hits(module)) == (2.0, 1)


def test_a_table_of_more_than_a_megabyte_is_kept_with_the_code(tmp_path: Path) -> None:
    """By itself numba takes such an array by its address, and writes no cache."""
    path = tmp_path / "scaled.py"
    text = TEXT.replace(
        "import numba", "import numba\nimport numpy as np\n\nTABLE = np.ones(150_000)"
    )
    path.write_text(text.format(factor="TABLE[int(x)]"))
    assert _execute(path).scaled(3.0) == 3.0
    module = _execute(path)
    assert (module.scaled(2.0), _hits(module)) == (2.0, 1)
    sys.modules.pop("scaled")


@pytest.mark.parametrize("kept", [0, 1, 20, 0.3, 0.9, -1])
@pytest.mark.parametrize("ending", ["nbi", "nbc"])
def test_a_file_that_is_cut_short_is_made_anew(source: Path, ending: str, kept: float) -> None:
    (path,) = source.parent.glob(f"__pycache__/*.{ending}")
    content = path.read_bytes()
    path.write_bytes(content[: int(kept * len(content)) if isinstance(kept, float) else kept])
    module = _execute(source)
    assert (module.scaled(1.0), _hits(module)) == (2.0, 0)
    assert _hits(_execute(source)) == 1  # without a warning, which would be an error


def _plain_python(path: Path) -> str:
    """What a process prints that imports a file with nothing but numba."""
    code = (
        f"import sys; sys.path.insert(0, {str(path.parent)!r}); from {path.stem} import scaled; "
        "assert 'codegen' not in sys.modules; "
        "print(scaled(1.0), sum(scaled.stats.cache_hits.values()))"
    )
    return subprocess.run(
        [sys.executable, "-c", code], check=True, env={}, stdout=subprocess.PIPE, text=True
    ).stdout


def _machine_code(path: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in path.parent.glob("__pycache__/*.nb*")}


def test_plain_python_imports_a_file_beside_its_checked_cache(source: Path) -> None:
    ours = _machine_code(source)
    assert [_plain_python(source) for _ in range(2)] == ["2.0 0\n", "2.0 1\n"]
    both = _machine_code(source)
    assert {name: both[name] for name in ours} == ours
    assert len(both) == 2 * len(ours)
    module = _execute(source)
    assert (module.scaled(1.0), _hits(module)) == (2.0, 1)


def test_a_cache_of_numba_itself_is_neither_read_nor_removed(tmp_path: Path) -> None:
    path = tmp_path / "scaled.py"
    path.write_text(TEXT.format(factor=2.0))
    assert _plain_python(path) == "2.0 0\n"
    before = _machine_code(path)
    for factor, hits in ((2.0, 0), (2.0, 1), (3.0, 0)):
        path.write_text(TEXT.format(factor=factor))
        module = _execute(path)  # without a warning, which would be an error
        assert (module.scaled(1.0), _hits(module)) == (factor, hits)
    assert before.items() <= _machine_code(path).items()
    sys.modules.pop("scaled", None)


def test_broken_files_of_a_writer_are_removed(source: Path) -> None:
    (old,) = source.parent.glob("__pycache__/*.nbc")
    half = old.with_name(f"{old.name}.tmp.0123")
    half.touch()
    source.write_text(TEXT.format(factor=3.0))
    assert _execute(source).scaled(1.0) == 3.0
    (new,) = source.parent.glob("__pycache__/*.nbc*")
    assert new not in (old, half)


def test_machine_code_is_kept_under_the_longest_names(
    tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    """Of a model, a scene and a companion, of a kernel far down in its file."""
    names = f"{'m' * 80}__{'s' * 80}__tangents"
    path = tmp_path / f"{names}.py"
    text = TEXT.format(factor=2.0).replace("scaled", "accelerations_tangent")
    path.write_text("\n" * 99_000 + text)
    for hits in (0, 1):
        kernel = _execute(path).accelerations_tangent
        assert (kernel(1.0), sum(kernel.stats.cache_hits.values())) == (2.0, hits)
    assert not recwarn.list
    sys.modules.pop("scaled", None)


def test_another_text_of_the_same_date_and_size_is_compiled(tmp_path: Path) -> None:
    path = tmp_path / "scaled.py"
    for factor in (2.0, 3.0):
        path.write_text(TEXT.format(factor=factor))
        os.utime(path, (1e9, 1e9))
        assert import_generated(path).scaled(1.0) == factor


def test_a_full_disk_keeps_nothing_and_blocks_nothing(tmp_path: Path) -> None:
    path = tmp_path / "scaled.py"
    path.write_text(TEXT.format(factor=2.0))
    limit, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, most))
    try:
        with pytest.warns(CacheWarning, match=r"not kept \(File too large\)"):
            module = _execute(path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, most))
        sys.modules.pop("scaled", None)
    assert module.scaled(1.0) == 2.0
    assert not list(tmp_path.glob("__pycache__/*.tmp.*"))


def test_no_folder_that_can_be_written_blocks_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "scaled.py"
    path.write_text(TEXT.format(factor=2.0))

    def none(function: object) -> None:
        raise RuntimeError("no locator available")

    monkeypatch.setattr(numba_cache.CheckedCache, "_impl_class", staticmethod(none))
    with pytest.warns(CacheWarning, match="kept nowhere"):
        assert _execute(path).scaled(1.0) == 2.0
    sys.modules.pop("scaled", None)


def test_an_interrupt_waits_until_a_function_is_compiled(
    source: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Raised within LLVM it would end the process: "double free or corruption"."""
    for path in source.parent.glob("__pycache__/*"):
        path.unlink()
    from numba.core.compiler import CompilerBase

    compiling, finished = CompilerBase.compile_extra, []

    def interrupted(self: object, function: object) -> object:
        os.kill(os.getpid(), signal.SIGINT)
        result = compiling(self, function)
        finished.append(True)
        return result

    monkeypatch.setattr(CompilerBase, "compile_extra", interrupted)
    usual = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            _execute(source)
    finally:
        signal.signal(signal.SIGINT, usual)
    assert finished

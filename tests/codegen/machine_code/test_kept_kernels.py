"""Machine code of kernels on the disk: never of another source, whole or absent."""

import os
import resource
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from codegen.files.generated_modules import import_generated
from codegen.machine_code import code_folders, kernels
from codegen.machine_code.code_folders import CacheWarning

TEXT = """import numba

OPTIONS = {{"cache": True, "error_model": "numpy"}}


@numba.njit("f8(f8)", **OPTIONS)
def scaled(x):
    return {factor} * x
"""


@pytest.fixture
def source(tmp_path: Path) -> Path:
    code_folders.note_unkept.cache_clear()
    path = tmp_path / "scaled.py"
    path.write_text(TEXT.format(factor=2.0))
    return path


def answer(path: Path) -> float:
    """What the kernel answers that is loaded as a new process loads it."""
    for name in [name for name in sys.modules if name.startswith("linkwright_generated_")]:
        if getattr(sys.modules[name].__loader__, "path", "") == str(path):
            del sys.modules[name]
    return float(import_generated(path).scaled(1.0))


def kept(path: Path) -> list[Path]:
    return sorted(path.parent.glob("__pycache__/*.lwo"))


def test_what_is_kept_is_taken(source: Path, translated: list[str]) -> None:
    assert [answer(source), answer(source)] == [2.0, 2.0]
    assert translated == ["scaled"]
    names = {path.name for path in (source.parent / "__pycache__").iterdir()}
    assert names == {kept(source)[0].name, "scaled.lock"}


@pytest.mark.parametrize("length", [0, 1, 20, 0.3, 0.9, -1])
def test_a_file_that_is_cut_short_is_made_anew(
    source: Path, translated: list[str], length: float
) -> None:
    answer(source)
    (file,) = kept(source)
    content = file.read_bytes()
    file.write_bytes(content[: int(length * len(content)) if 0 < length < 1 else int(length)])
    assert [answer(source), answer(source)] == [2.0, 2.0]
    assert translated == ["scaled"] * 2


def test_another_text_of_the_same_date_and_size_is_compiled(source: Path) -> None:
    for factor in (2.0, 3.0, 2.0):
        source.write_text(TEXT.format(factor=factor))
        os.utime(source, (1e9, 1e9))
        assert answer(source) == factor


def test_two_processors_or_versions_in_turn(
    source: Path, translated: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for surroundings in (b"one", b"another", b"one", b"another"):
        monkeypatch.setattr(code_folders, "_surroundings", lambda s=surroundings: s)
        assert answer(source) == 2.0
    assert translated == ["scaled"] * 2
    assert len(kept(source)) == 2


@pytest.mark.parametrize(
    ("name", "value"), [("NUMBA_CPU_NAME", "generic"), ("LINKWRIGHT_NUMBA", "plain")]
)
def test_surroundings_count(monkeypatch: pytest.MonkeyPatch, name: str, value: str) -> None:
    usual = code_folders._surroundings.__wrapped__()
    monkeypatch.setenv(name, value)
    assert code_folders._surroundings.__wrapped__() != usual


@pytest.mark.parametrize("count", ["{}", "len('{}')"], ids=["translated", "by numba"])
def test_the_newest_states_are_kept(source: Path, count: str) -> None:
    for factor in range(8):
        source.write_text(TEXT.format(factor=count.format("8" * factor or "0")))
        answer(source)
    states = [*source.parent.glob("__pycache__/scaled.*[0-9a-f]"), *kept(source)]
    assert code_folders._KEPT <= len(states) <= code_folders._KEPT + 1


@pytest.mark.parametrize("folder", ["with spaces", "mit Ümläuten ÄÖß", "link"])
def test_folders_of_every_name(tmp_path: Path, translated: list[str], folder: str) -> None:
    place = tmp_path / folder
    if folder == "link":
        (tmp_path / "real").mkdir()
        place.symlink_to(tmp_path / "real")
    place.mkdir(exist_ok=True)
    path = place / "scaled.py"
    path.write_text(TEXT.format(factor=2.0))
    assert [answer(path), answer(path)] == [2.0, 2.0]
    assert translated == ["scaled"]


def test_the_longest_names(tmp_path: Path, translated: list[str]) -> None:
    path = tmp_path / f"{'m' * 80}__{'s' * 80}__tangents.py"
    path.write_text("\n" * 99_000 + TEXT.format(factor=2.0))
    assert [answer(path), answer(path)] == [2.0, 2.0]
    assert translated == ["scaled"]


def test_a_full_disk_keeps_nothing_and_blocks_nothing(source: Path) -> None:
    answer(source)  # the caller of kernels from Python is kept elsewhere
    source.write_text(TEXT.format(factor=3.0))
    limit, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, most))
    try:
        with pytest.warns(CacheWarning, match="its disk is full. Set .*NUMBA_CACHE_DIR"):
            assert answer(source) == 3.0
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, most))
    assert len(kept(source)) == 1
    assert not [*source.parent.glob("__pycache__/.lw-*")]


def test_a_text_that_numba_compiles_needs_no_folder(
    source: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (source.parent / "__pycache__").write_text("no folder")
    source.write_text(TEXT.format(factor="len('xx')"))  # which is not translated
    monkeypatch.setenv("XDG_CACHE_HOME", str(source))
    with pytest.warns(CacheWarning, match="cannot be kept"):
        assert answer(source) == 2.0


def test_threads_that_load_two_modules_take_turns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two at once made two engines of one target machine, and the first went with its code."""
    usual, at_work, most = kernels._kept_code, [], []

    def watched(path: Path, *arguments: Any) -> bytes:
        at_work.append(path)
        time.sleep(0.1)
        most.append(len(at_work))
        at_work.remove(path)
        return usual(path, *arguments)

    monkeypatch.setattr(kernels, "_kept_code", watched)
    paths = [tmp_path / f"scaled_{k}.py" for k in range(3)]
    for k, path in enumerate(paths):
        path.write_text(TEXT.format(factor=float(k)))
    with ThreadPoolExecutor(3) as pool:
        modules = [*pool.map(import_generated, paths)]
    assert [module.scaled(1.0) for module in modules] == [0.0, 1.0, 2.0]
    assert most == [1, 1, 1]


def test_threads_that_decorate_take_turns(tmp_path: Path) -> None:
    usual = code_folders._config.CACHE_DIR

    def decorate(name: str) -> set[bool]:
        found = set()
        for _ in range(50):
            with code_folders.numba_keeps_in(tmp_path / name):
                time.sleep(0.0001)
                found.add(str(tmp_path / name) == code_folders._config.CACHE_DIR)
        return found

    with ThreadPoolExecutor(2) as pool:
        assert [*pool.map(decorate, ("one", "two"))] == [{True}, {True}]
    assert usual == code_folders._config.CACHE_DIR


def test_a_folder_that_cannot_be_written_has_its_code_in_the_users_cache(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (source.parent / "__pycache__").write_text("no folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "user"))
    assert answer(source) == 2.0
    assert len([*(tmp_path / "user").rglob("*.lwo")]) == 1
    monkeypatch.setenv("XDG_CACHE_HOME", str(source))  # which is a file, no folder
    with pytest.warns(CacheWarning, match="cannot be kept") as told:
        assert [answer(source), answer(source)] == [2.0, 2.0]
    assert len(told) == 1


def test_a_warning_that_is_an_error_ends_nothing(
    source: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (source.parent / "__pycache__").write_text("no folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(source))
    assert answer(source) == 2.0  # warnings are errors in all tests
    assert "linkwright precompile" in capsys.readouterr().err


def test_code_that_can_only_be_read_is_read(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, translated: list[str]
) -> None:
    assert answer(source) == 2.0
    usual = code_folders.is_writable
    monkeypatch.setattr(
        code_folders, "is_writable", lambda folder: folder.name != "__pycache__" and usual(folder)
    )
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "user"))
    assert answer(source) == 2.0
    assert translated == ["scaled"]
    source.write_text(TEXT.format(factor=3.0))  # which is kept where it can be
    assert [answer(source), answer(source)] == [3.0, 3.0]
    assert translated == ["scaled", "scaled"]


PRINT = """
import sys
from pathlib import Path
from codegen.files.generated_modules import import_generated
print(import_generated(Path(sys.argv[1])).scaled(1.0))
"""


def test_processes_at_once_and_a_folder_of_the_users(source: Path, root: Path) -> None:
    cache = source.parent / "cache"
    environment = {**os.environ, "PYTHONPATH": str(root), "NUMBA_CACHE_DIR": str(cache)}
    processes = [
        subprocess.Popen([sys.executable, "-c", PRINT, source], env=environment,
                         stdout=subprocess.PIPE, text=True)
        for _ in range(3)
    ]  # fmt: skip
    assert [process.communicate()[0] for process in processes] == ["2.0\n"] * 3
    assert len([*cache.rglob("scaled.*.lwo")]) == 1
    assert not kept(source)


def test_an_interrupt_waits_until_kernels_are_compiled(
    source: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Raised within LLVM it would end the process: "double free or corruption"."""
    import signal

    usual, finished = kernels.object_code, []

    def interrupted(text: str) -> bytes:
        signal.raise_signal(signal.SIGINT)
        code = usual(text)
        finished.append(True)
        return code

    monkeypatch.setattr(kernels, "object_code", interrupted)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            answer(source)
    finally:
        signal.signal(signal.SIGINT, before)
    assert finished

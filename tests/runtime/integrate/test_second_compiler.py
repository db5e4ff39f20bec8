"""The process that compiles the loop beside a first run."""

import json
import os
import subprocess
import sys

import pytest

from runtime.integrate import second_compiler
from runtime.integrate.loop import advance
from runtime.integrate.stability_limit import idle

_BESIDE = """
import linkwright
from runtime.core.jit import is_kept, prepare
from runtime.integrate import second_compiler
from runtime.integrate.stability_limit import idle
second_compiler.can_start = lambda: True
before = is_kept(idle)
second_compiler.compile_beside([idle])
second_compiler._running[0].wait(300)
print(before, is_kept(idle))
prepare(idle)
print(sum(idle.stats.cache_hits.values()), sum(idle.stats.cache_misses.values()))
"""


def test_what_the_other_process_compiles_is_taken_from_the_cache(tmp_path, root):
    """Also where the user's folder has a file of our package's name."""
    (tmp_path / "runtime.py").write_text("open('executed', 'w')")
    given = {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(root)}
    done = subprocess.run(
        [sys.executable, "-c", _BESIDE], env={**os.environ, **given}, cwd=tmp_path,
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.split() == ["False", "True", "1", "0"]
    assert not (tmp_path / "executed").exists()


def test_it_ends_with_the_process_that_started_it(tmp_path):
    call = second_compiler.__name__, "compile_named", [(advance.__module__, advance.__name__)]
    argument = json.dumps([sys.path, call])
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", second_compiler.PROGRAM, argument],
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}, stdin=subprocess.PIPE,
    )  # fmt: skip
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(1.0)
    process.communicate(timeout=60)
    assert process.returncode == 0
    assert not [*tmp_path.rglob("loop.advance*.nbc")]  # it had not come to the end


def test_one_core_compiles_alone(monkeypatch):
    monkeypatch.setattr(second_compiler, "can_start", lambda: False)
    before = [*second_compiler._running]
    second_compiler.compile_beside([idle])
    assert second_compiler._running == before


def test_a_system_that_starts_no_process_compiles_alone(monkeypatch):
    def refuse(*_, **__):
        raise PermissionError

    monkeypatch.setattr(second_compiler, "can_start", lambda: True)
    monkeypatch.setattr(second_compiler.subprocess, "Popen", refuse)
    before = [*second_compiler._running]
    second_compiler.compile_beside([idle])
    assert second_compiler._running == before

"""The tests' own compilation: a kernel that two files have in common is compiled once."""

import sys
from pathlib import Path

import pytest

from codegen.generated_module_signature_and_import import import_generated
from tests.machine_code import compile_apart

TEXT = '''import numba

RATE = {rate}
OPTIONS = {{"cache": True}}


@numba.njit(**OPTIONS)
def rate():
    return RATE


@numba.njit("f8(f8)", **OPTIONS)
def twice(x):
    """Double x, in a file where the rate is {rate}."""
    return 2.0 * x


@numba.njit("f8(f8)", **OPTIONS)
def scaled(x):
    return rate() * x
'''


@pytest.mark.skipif(sys.platform != "linux", reason="processes are forked on Linux alone")
def test_equal_kernels_are_compiled_once(tmp_path: Path) -> None:
    kept = tmp_path / "kept"
    for rate in (3.0, 4.0):
        path = tmp_path / f"rate_{rate:g}.py"
        path.write_text(TEXT.format(rate=rate))
        compile_apart(path.stem, path, kept)
        module = import_generated(path)
        assert (module.twice(1.0), module.scaled(1.0)) == (2.0, rate)
        assert not {**module.twice.stats.cache_misses, **module.scaled.stats.cache_misses}
    # `twice` of both; of either file its rate, and what calls it.
    assert len(list(kept.iterdir())) == 5

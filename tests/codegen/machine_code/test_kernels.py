"""Kernels are translated for LLVM, and compute what Python and numba take from their text."""

import importlib
import math
import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from codegen.emit.module import Origin, module_text
from codegen.files.generated_modules import _IMPORT, _Text, import_generated
from codegen.machine_code import kernels
from tests.codegen.machine_code.kernel_texts import EXACT, HEAD, plain, python_only
from tests.codegen.reroll.machines import lowered

CONTRACTED = 'OPTIONS = {"cache": False, "error_model": "numpy", "fastmath": {"contract"}}'
CONSTRUCTS = '''
LIMIT = 0.5
KNOTS = np.array((-1.0, 0.0, 0.5, 2.0))
ROWS = np.array(((1.0, 2.0), (3.0, -4.0), (0.25, 0.5), (1e-3, 7.0)))
PLACES = np.array((3, 0, 2, 1), dtype=np.uint32)
SPANS = np.array((0, 1, 3, 3))


@numba.njit(**OPTIONS)
def pair(x):
    """Two numbers."""
    if not abs(x) < 1.0:
        return math.sin(x), math.cos(x)
    k = math.floor(x * 4.0)
    return (x * k if k & 1 else -x), float(k)


@numba.njit("Tuple((i8, f8))(f8)", **OPTIONS)
def interval(x):
    x -= 4.0 * math.floor((x + 1.0) / 4.0)
    low, high = 0, 4
    while high - low > 1:
        middle = (low + high) // 2
        if x < KNOTS[middle]:
            high = middle
        else:
            low = middle
    return low, x - KNOTS[low]


@numba.njit("f8(f8)", **OPTIONS)
def polygon(x):
    k, s = interval(x)
    c = ROWS
    return c[k, 0] + s * c[k, 1]


@numba.njit("i8(f8, f8[::1], i8[::1], f8[::1])", **OPTIONS)
def kernel(t, q, modes, out):
    """A kernel.

    Of all that kernels have.
    """
    x = q[0]
    y = q[1]
    a, b = pair(x)
    mode = modes[0]
    out[0] = a - b * (x + y) / (1.0 + y * y)
    out[1] = (x if mode else y) if not mode == 2 else -t
    out[2] = polygon(x) + polygon(-y) * x // 1.0
    out[3] = math.atan2(y, x) + math.tanh(x) + math.exp(-y) + math.sqrt(x * x) + math.pow(2.0, y)
    total = 0.0
    for k in range(4):
        total += q[PLACES[k]] * (k + 1)
        if total > 1e3 and x > LIMIT or not x < 7.0:
            total = 1.0
    for k in range(SPANS[mode], SPANS[mode + 1]):
        total += k * x
    for k in range(PLACES[1], PLACES[2]):
        total += q[3 - k]
    for k in range(2):
        out[k + 4] = total * (k + 1)
    w = math.nan if -1.0 <= x <= LIMIT else 2
    z = 3 if x > y else 4
    out[6] = w
    out[7] = z * x + (1.0 if mode != 1 else 0.0)
    if x > y:
        if y > 0.0:
            return 1
        out[8] = x
    elif y > LIMIT:
        out[8] = y
    else:
        out[8] = 0
        return PLACES[mode]
    return 0
'''


def outputs(kernel: Callable[..., Any], q: Any, mode: int) -> list[Any]:
    out = np.full(9, -1.0)
    return [kernel(0.75, q.copy(), np.array([mode]), out), *out.tolist()]


def test_every_construct(imported: Any, translated: list[str]) -> None:
    ours, numbas = imported(EXACT, CONSTRUCTS).kernel, plain(EXACT, CONSTRUCTS)["kernel"]
    assert translated == ["interval", "polygon", "kernel"]
    python = python_only(CONSTRUCTS)["kernel"]
    generator = np.random.default_rng(3)
    answers = set()
    for mode in (0, 1, 2):
        for q in (*generator.normal(size=(40, 4)), *generator.normal(scale=9.0, size=(10, 4))):
            result = outputs(ours, q, mode)
            np.testing.assert_array_equal(result, outputs(numbas, q, mode))
            np.testing.assert_array_equal(result, outputs(python, q, mode))
            answers.add(result[0])
    assert answers == {0, 1, 2, 3}


NUMBERS = st.sampled_from(["x", "y", "z", "0.5", "-2.0", "k", "q[1]"])
CONDITIONS = st.builds(
    "{} {} {}".format, NUMBERS, st.sampled_from(["<", "<=", ">", ">=", "==", "!="]), NUMBERS
)


def _larger(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    tests = st.one_of(
        CONDITIONS,
        st.builds("not ({})".format, CONDITIONS),
        st.builds("({} and {})".format, CONDITIONS, CONDITIONS),
        st.builds("({} or not {})".format, CONDITIONS, CONDITIONS),
        st.builds("{} <= {} < {}".format, NUMBERS, NUMBERS, NUMBERS),
    )
    return st.one_of(
        st.builds("({} {} {})".format, inner, st.sampled_from(["+", "-", "*"]), inner),
        st.builds("{} / (1.5 + abs(0.0 + {}))".format, inner, inner),
        st.builds("-({})".format, inner),
        st.builds("math.sin({})".format, inner),
        st.builds("math.sqrt(abs(1.0 * {}))".format, inner),
        st.builds("({} if {} else 1.0 * {})".format, st.just("x"), tests, inner),
    )


EXPRESSIONS = st.recursive(NUMBERS, _larger, max_leaves=12)
PROGRAM = """
@numba.njit("f8(f8[::1], f8[::1])", **OPTIONS)
def kernel(q, out):
    x = q[0]
    y = q[2]
    z = 0.0
    k = 2
    z = 1.0 * {}
    for k in range(3):
        if {} > x:
            z = 0.5 * z - {}
        else:
            out[k] = z
    out[3] = {}
    return 1.0 * z
"""


@settings(max_examples=150, deadline=None)
@given(
    st.tuples(EXPRESSIONS, EXPRESSIONS, EXPRESSIONS, EXPRESSIONS),
    st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3),
)
def test_programs_compute_what_python_does(
    tmp_path_factory: pytest.TempPathFactory, parts: tuple[str, ...], q: list[float]
) -> None:
    text = PROGRAM.format(*parts)
    name = f"program_{abs(hash(text))}"
    path = str(tmp_path_factory.getbasetemp() / f"{name}.py")
    source = _Text(path, f"{HEAD}{EXACT}\n{text}")
    sys.modules[name] = module = ModuleType(name)
    try:
        source.execute(vars(module))
    finally:
        del sys.modules[name]
    ours, python = np.zeros(4), np.zeros(4)
    result = module.kernel(np.array(q), ours)
    assert result == python_only(text)["kernel"](np.array(q), python)
    np.testing.assert_array_equal(ours, python)


FROM_THE_END = """
TABLE = np.array(((1.0, 2.0, 3.0), (4.0, 5.0, 6.0)))
PLACES = np.array((2, 0, 1), dtype=np.uint32)


@numba.njit("f8(i8[::1], f8[::1])", **OPTIONS)
def kernel(modes, out):
    for n in range(6):
        k = n - 3
        out[k] = out[k] + TABLE[-1, k] * TABLE[modes[0], -2]
        out[k - PLACES[1]] = out[k] - 0.25 * k
    out[-1] = PLACES[-2] * out[-2]
    return out[modes[-1]]
"""


def test_places_may_count_from_the_end(imported: Any, translated: list[str]) -> None:
    results = []
    for names in (vars(imported(EXACT, FROM_THE_END)), plain(EXACT, FROM_THE_END)):
        out = np.arange(3.0)
        results.append([names["kernel"](np.array([-2, 1, -3]), out), *out.tolist()])
    assert translated == ["kernel"]
    assert results[0] == results[1]


def test_a_long_sum_and_a_deep_expression(imported: Any) -> None:
    long, deep = " + ".join(["x"] * 800), "(x + " * 90 + "x" + ")" * 90
    text = f'@numba.njit("f8(f8)", **OPTIONS)\ndef kernel(x):\n    return {long} + {deep}\n'
    assert imported(EXACT, text).kernel(1.0) == 891.0


def test_products_and_sums_may_be_contracted(imported: Any) -> None:
    text = '@numba.njit("f8(f8, f8, f8)", **OPTIONS)\ndef kernel(a, b, c):\n    return a * b + c\n'
    a = 1.0 + 2.0**-30
    separate, contracted = (
        imported(options, text).kernel(a, a, -1.0) for options in (EXACT, CONTRACTED)
    )
    assert separate == a * a - 1.0
    assert contracted in (separate, 2.0**-29 + 2.0**-60)
    numbas = plain(CONTRACTED, text)["kernel"]
    assert contracted == numbas(a, a, -1.0)


def declared(path: Path) -> tuple[list[Any], dict[str, Any]]:
    """The kernels of a generated file, and the names of its text."""
    names: dict[str, Any] = {"numba": kernels.NumbaOfTexts(kernels.declare)}
    exec(_IMPORT.sub("", path.read_text(), count=1), names)
    found = [one for one in names.values() if isinstance(one, kernels.Kernel) and one.declared]
    return found, names


def assert_translated(path: Path) -> None:
    found, names = declared(path)
    symbols = [one.__name__ for one in found]
    text = kernels._translation(path.read_text(), found, symbols, names).decode()
    for symbol in symbols:
        assert text.count(f'define i32 @"{symbol}"(') == 1


def test_the_library_is_translated(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No kernel of a generated file is left to numba, which would take several times as long."""
    monkeypatch.setattr(kernels, "object_code", str.encode)
    paths = sorted((root / "generated").glob("[a-z]*__*.py"))
    assert len(paths) > 20
    for path in paths:
        assert_translated(path)


def test_kernels_in_batches_are_translated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Machines without a period, whose kernels are loops over spans of a table."""
    monkeypatch.setattr(kernels, "object_code", str.encode)
    monkeypatch.setattr("codegen.emit.module.LONGEST_KERNEL", 3000)
    text = module_text(lowered("tree", 5), Origin("linkwright", (), "0" * 64, "build"))
    assert re.search(r"for k in range\(.+, .+\):", text)
    path = tmp_path / "tree__fall.py"
    path.write_text(text)
    assert_translated(path)


@pytest.mark.parametrize("name", ["slider_crank__compressor", "pendulum__bar__tangents"])
def test_a_text_by_itself_has_the_same_numbers(root: Path, name: str) -> None:
    """To the last contraction: numba compiles it, with nothing of ours."""
    ours = import_generated(root / "generated" / f"{name}.py")
    numbas = importlib.import_module(f"generated.{name}")
    found = [one for one in vars(ours).values() if isinstance(one, kernels.Kernel) and one.declared]
    assert found
    generator = np.random.default_rng(5)
    for kernel in found:
        other = getattr(numbas, kernel.__name__)
        assert not isinstance(other, kernels.Kernel)
        for _ in range(20):
            answers = []
            given = [
                generator.normal(size=200) if "float64, 1d" in str(kind)
                else generator.integers(0, 2, 200) if "1d" in str(kind) else generator.normal()
                for kind in kernel.declared.args
            ]  # fmt: skip
            for function in (kernel, other):
                arrays = [np.copy(one) if np.ndim(one) else one for one in given]
                answers.append([function(*arrays), *arrays])
            for mine, its in zip(*answers, strict=True):
                np.testing.assert_array_equal(mine, its)


ROOM = """
@numba.njit("i8(f8[::1], f8[::1])", **OPTIONS)
def kernel(q, out):
    few = np.empty(3)
    many = np.empty(8193)
    for k in range(8193):
        many[k] = q[0] + k
        few[2] = many[k]
    if q[0] > 0.0:
        return 1
    out[0] = few[-1] * many[17]
    return 0
"""


def test_arrays_of_a_kernel_lie_on_the_stack_and_long_ones_on_the_heap(
    imported: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    texts, code = [], kernels.object_code
    monkeypatch.setattr(kernels, "object_code", lambda text: (texts.append(text), code(text))[1])
    ours = imported(CONTRACTED, ROOM).kernel
    assert (texts[0].count('@"malloc"('), texts[0].count('@"free"(')) == (2, 3)  # a declaration
    for x in (-1.5, 1.5):
        answers = []
        for function in (ours, plain(CONTRACTED, ROOM)["kernel"], python_only(ROOM)["kernel"]):
            out = np.zeros(1)
            answers.append((function(np.array([x]), out), *out))
        assert answers[0] == answers[1] == answers[2]


def test_rounding_down_of_what_is_not_finite(imported: Any) -> None:
    text = '@numba.njit("f8(f8)", **OPTIONS)\ndef kernel(x):\n    return x // 1.0\n'
    kernel = imported(EXACT, text).kernel
    for x in (0.0, -0.0, 2.5, -2.5, 1e300, -1e-300, math.inf, -math.inf, math.nan):
        np.testing.assert_array_equal(kernel(x), x // 1.0)
        assert math.isnan(kernel(x)) or np.signbit(kernel(x)) == np.signbit(x // 1.0)

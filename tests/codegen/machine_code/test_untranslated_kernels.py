"""Numba compiles what is not translated, and unusual texts compute what they do in numba."""

from typing import Any

import numpy as np
import pytest

from tests.codegen.machine_code.kernel_texts import EXACT, plain, python_only

VECTORS = '@numba.njit("void(f8[::1], f8[::1])", **OPTIONS)\ndef kernel(q, out):\n    {}\n'
OF_X = '@numba.njit("f8(f8)", **OPTIONS)\ndef kernel(x):\n    {}\n'


@pytest.mark.parametrize(
    "line",
    [
        "out[0] = sum(q)",
        "out[0] = len(q)",
        "out[:] = 1.0",
        "while True:\n        break",
        "out[0] = math.log1p(q[0])",
        "out[0] = q[0] % 2.0",
        "try:\n        out[0] = 1.0\n    finally:\n        pass",
    ],
)
def test_numba_compiles_what_is_not_translated(
    line: str, imported: Any, translated: list[str]
) -> None:
    text, out, expected = VECTORS.format(line), np.zeros(2), np.zeros(2)
    imported(EXACT, text).kernel(np.array([1.25, 3.0]), out)
    python_only(text)["kernel"](np.array([1.25, 3.0]), expected)
    assert translated == []
    np.testing.assert_array_equal(out, expected)


def test_numba_compiles_two_kernels_of_one_name(imported: Any, translated: list[str]) -> None:
    module = imported(EXACT, f"{OF_X.format('return 2.0 * x')}\n\nother = kernel\n")
    assert (module.kernel(3.0), module.other(3.0), translated) == (6.0, 6.0, [])


ENTRIES = """
PLACES = np.array((3, 0, 2, 1), dtype=np.uint32)


@numba.njit(**OPTIONS)
def difference(a, b):
    return a - b


"""


@pytest.mark.parametrize(
    "line",
    [
        "out[0] = PLACES[0] - PLACES[1]",
        "out[0] = PLACES[0] * PLACES[1] - 1",
        "out[0] = -PLACES[1]",
        "out[0] = math.floor(PLACES[1]) - PLACES[0]",
        "k = PLACES[1] if q[0] > 0.0 else PLACES[0]\n    out[0] = k - PLACES[0]",
        "out[0] = difference(PLACES[1], PLACES[0])",
        "for k in range(PLACES[1], PLACES[0]):\n        out[0] = k - PLACES[0]",
    ],
)
def test_numba_calculates_with_entries_without_sign(
    line: str, imported: Any, translated: list[str]
) -> None:
    text, out, expected = ENTRIES + VECTORS.format(line), np.zeros(2), np.zeros(2)
    imported(EXACT, text).kernel(np.array([1.25, 3.0]), out)
    plain(EXACT, text)["kernel"](np.array([1.25, 3.0]), expected)
    assert translated == []
    np.testing.assert_array_equal(out, expected)


def test_names_that_are_no_ascii(imported: Any, translated: list[str]) -> None:
    twice = "@numba.njit(**OPTIONS)\ndef zweifach_für(x):\n    return μ[0] * x\n\n\n"
    body = "ω = zweifach_für(λ)\n    return ω"
    text = f"μ = np.array((2.0, 3.0))\n\n\n{twice}{OF_X.format(body).replace('(x)', '(λ)')}"
    assert imported(EXACT, text).kernel(1.25) == 2.5
    assert translated == ["kernel"]


@pytest.mark.parametrize(
    ("before", "body"),
    [
        ("sqrt = np.array((2.0, 3.0))", "return sqrt[0] * math.sqrt(x)"),
        ('@numba.njit("i8(i8)", **OPTIONS)\ndef twice(n):\n    return 2 * n',
         "return 1.0 * twice(2) + x"),
        ('@numba.njit("f8(f8)", **OPTIONS)\ndef half(x):\n    return x / 2 * 1e9 * x',
         "return half(4000000000) + x"),
        ("", "y = 1.0\n# here\n    return x + y"),
        ("", '"""Two\nlines."""\n    return x'),
        ("def abs(x):\n    return -10.0 * x\n\n\nabs = numba.njit(abs)", "return abs(x)"),
        ("T = np.array(((1.0, 2.0), (3.0, 5.0)))", "return T[1, -1] * x"),
        ("", "y = x\n    y = 0\n    return math.atan2(-y, -1.0)"),
        ('@numba.njit("i8(f8)", **OPTIONS)\ndef f(x):\n    return math.floor(x * 1.5)',
         "return f(x) * 1.0"),
        ('@numba.njit("f8(f8)", **OPTIONS)\ndef f(x):\n    return 0',
         "return math.atan2(-f(x), -1.0)"),
        (("@numba.njit(**OPTIONS)\ndef neg(n):\n    return -n\n\n\n"
         '@numba.njit("f8(f8)", **OPTIONS)\ndef first(x):\n    return neg(x) + len((1, 2))'),
         "return math.atan2(neg(0), -1.0)"),
        (('@numba.njit("f8(f8)", fastmath=True, error_model="numpy")\n'
         "def f(x):\n    return (x + 1e300) - 1e300"), "return f(x)"),
        ("@numba.njit(**OPTIONS)\ndef whole(n):\n    return 0",
         "return math.atan2(-whole(x), -1.0)"),
        ("", "math = x\n    return math"),
        ("", "y = x > 1.0\n    return y + 1.5"),
        ("", "y = not 1.0 < x < 2.0 and (x > 3.0 or x < 0.0)\n    return 2.0 if y else 3.0"),
    ],
)  # fmt: skip
def test_unusual_texts_compute_what_numba_does(before: str, body: str, imported: Any) -> None:
    text = f"{before}\n\n\n{OF_X.format(body)}"
    assert imported(EXACT, text).kernel(9.0) == plain(EXACT, text)["kernel"](9.0)

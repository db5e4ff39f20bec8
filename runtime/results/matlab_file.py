"""Results as MATLAB files: one struct, whose fields have names that MATLAB accepts."""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from runtime.results.result import Result

FloatArray = npt.NDArray[np.float64]

_LONGEST = 63  # layout: characters of a name in MATLAB (namelengthmax)
_KEYWORDS = {
    *("break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for"),
    *("function", "global", "if", "otherwise", "parfor", "persistent", "return", "spmd"),
    *("switch", "try", "while"),
}
_HEADING = re.compile(r"(?P<name>.*?)(?: \[(?P<unit>[^\]]*)\])?")


def field_names(names: Iterable[str]) -> list[str]:
    """Names that MATLAB accepts, each another one, in order: ``a(bob.phi)`` is ``a_bob_phi``.

    MATLAB takes ASCII letters, digits and underscores, a letter first, 63 characters at most, and
    no keyword. Another letter becomes its number: ``φ`` is ``u03c6``.
    """
    taken = dict[str, None]()
    for name in names:
        letters = "".join(c if c.isascii() else f"u{ord(c):04x}" for c in name)
        plain = re.sub(r"[^A-Za-z0-9]+", "_", letters).strip("_")
        if not plain[:1].isalpha() or plain in _KEYWORDS:
            plain = f"x_{plain}"
        field, count = plain[:_LONGEST], 1
        while field in taken:
            count += 1
            tail = f"_{count}"
            field = f"{plain[: _LONGEST - len(tail)]}{tail}"
        taken[field] = None
    return list(taken)


def content(result: Result, columns: Mapping[str, FloatArray]) -> dict[str, Any]:
    """The struct of a result: `series`, their `names` and `units`, `parameters`, and texts."""
    headings = [_HEADING.fullmatch(column) for column in columns]
    labels = [match["name"] if match else "" for match in headings]
    units = [(match["unit"] if match else "") or "" for match in headings]
    fields = field_names(labels)
    values = (np.asarray(column, np.float64).reshape(-1, 1) for column in columns.values())

    def struct(of: Mapping[str, Any]) -> dict[str, Any]:
        return dict(zip(field_names(of), of.values(), strict=True))

    return {
        "series": dict(zip(fields, values, strict=True)),
        "names": dict(zip(fields, labels, strict=True)),
        "units": dict(zip(fields, units, strict=True)),
        "parameters": struct(result.parameters),
        "about": struct(result.about()),
    }


def write(result: Result, columns: Mapping[str, FloatArray], path: Path) -> None:
    """Write the struct `result`; InputError where a series is too long for the format."""
    from scipy.io import savemat
    from scipy.io.matlab import MatWriteError

    struct = content(result, columns)
    try:
        with path.open("wb") as file:
            savemat(file, {"result": struct}, long_field_names=True, do_compression=True)
    except MatWriteError as error:
        raise InputError(f"{path.name}: {error}. Save as .nc or .zarr.") from error

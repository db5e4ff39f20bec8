"""Sensitivity of a study: SALib's designs and indices, an extra."""

import warnings
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.object_display import counted

if TYPE_CHECKING:
    import pandas as pd

    from runtime.sweeps.study import Study

FloatArray = npt.NDArray[np.float64]
_LEAST = 100  # accuracy: runs from which delta is worth its name


def _salib(module: str) -> ModuleType:
    """A module of SALib; InputError with the command that installs it."""
    from importlib import import_module

    try:
        return import_module(f"SALib.{module}")
    except ImportError as error:
        raise InputError(
            "Sensitivity indices need SALib, which is not installed. Run pip install "
            "'linkwright[sensitivity]', in the checkout pip install '.[sensitivity]'."
        ) from error


def _problem(names: tuple[str, ...] | list[str]) -> dict[str, Any]:
    return {
        "num_vars": len(names),
        "names": np.array([*names]),
        "bounds": [[0.0, 1.0]] * len(names),
    }


def saltelli_points(dimensions: int, count: int, seed: int) -> FloatArray:
    """Saltelli's design for Sobol's indices: (count (dimensions + 2), dimensions), from 0 to 1.

    `count` must be a power of 2, of which Sobol's sequence is balanced.
    """
    sampler = _salib("sample.sobol")
    if count & (count - 1):
        near = 2 ** max(round(np.log2(count)), 1)
        raise InputError(
            f"count is {count}; of the sample saltelli it must be a power of 2, such as {near}."
        )
    problem = _problem([f"x{k}" for k in range(dimensions)])
    return np.asarray(sampler.sample(problem, count, calc_second_order=False, seed=seed))


def _analyzed(method: str, *arguments: Any, **words: Any) -> dict[str, Any]:
    """The answer of an analysis of SALib, the last argument being the seed, without its notices."""
    analyze = _salib(f"analyze.{method}").analyze
    *data, seed = arguments
    usual = warnings.formatwarning
    try:
        with warnings.catch_warnings(record=True):  # SALib has a filter of its own
            found = analyze(*data, **words, seed=seed + 1, print_to_console=False)  # 0 is no seed
    finally:
        warnings.formatwarning = usual  # which SALib changes
    return dict(found)


def indices_of(study: "Study", quantity: str, seed: int) -> "pd.DataFrame":
    """Indices of a quantity, one row a factor; see `Study.sensitivity`."""
    import pandas as pd

    design = study.facts()["design"]
    values, problem = study.data[quantity].values, _problem(study.factors)
    known = np.isfinite(values)
    if design["kind"] == "saltelli":
        if not known.all():
            raise InputError(
                f"{counted(int((~known).sum()), 'run')} of {len(values)} have no {quantity}, and "
                "Sobol's indices need them all: leave out of the intervals what makes no machine, "
                "or take a sample lhs, of which runs may be missing."
            )
        found = _analyzed("sobol", problem, values, seed, calc_second_order=False)
        names = ("S1", "S1_conf", "ST", "ST_conf")
    else:
        if design["axes"]:
            raise InputError(
                "Indices are means over a distribution, and the design is a grid. Sweep with "
                "--sample saltelli (Sobol's indices), or lhs (delta)."
            )
        if known.sum() < _LEAST:
            raise InputError(
                f"{counted(int(known.sum()), 'run')} have {quantity}; indices take at least "
                f"{_LEAST}."
            )
        points = np.stack([study.data[name].values[known] for name in study.factors], axis=1)
        found = _analyzed("delta", problem, points, values[known], seed)
        if "delta" not in found:  # from SALib 1.6 on, by the way of its estimate
            found |= {"delta": found["delta_raw"], "delta_conf": found["delta_raw_conf"]}
        names = ("delta", "delta_conf", "S1", "S1_conf")
    table = {name: np.asarray(found[name], dtype=float) for name in names}
    return pd.DataFrame(table, index=pd.Index(study.factors, name="factor"))

"""Arrays of a result file from elsewhere: of the shapes that compiled code expects, or refused.

Compiled code checks no index. What it would take from such a file are states, whose shapes are
checked here, and checkpoints, which are copies of its own memory and are left out: `Result.at` then
begins at the start of the run, with the same bits.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from runtime.mechanism.module_tables import Description

_HIGHEST_MODE = 2  # of a switching function that stays at zero


def plain_arrays(saved: dict[str, Any], description: Description) -> dict[str, Any]:
    """What a file keeps of a result, without checkpoints, its arrays checked.

    Raises InputError where an array has another shape than the machine, KeyError where one is
    missing.
    """
    motion = saved["motion"]
    n, switches = len(description.coordinates), len(description.switches)
    samples = saved["samples"]
    count = len(_floats(samples["t"], (-1,), "t"))
    modes = np.asarray(samples["modes"])
    if modes.shape != (count, switches) or modes.dtype.kind not in "iu" or not (
        (modes >= 0) & (modes <= _HIGHEST_MODE)
    ).all():  # fmt: skip
        raise _misfit("modes", modes, (count, switches))
    checked = {
        "t": _floats(samples["t"], (count,), "t"),
        "q": _floats(samples["q"], (count, n), "q"),
        "v": _floats(samples["v"], (count, n), "v"),
        "modes": modes.astype(np.int64),
    }
    if motion is not None:
        motion = dict(motion)
        for name in {"q", "v", "preferred"} & motion.keys():
            motion[name] = _floats(motion[name], (n,), name)
        if "times" in motion:
            motion["times"] = _floats(motion["times"], (-1,), "times")
        if "checkpoints" in motion:
            motion["checkpoints"] = []
    return {**saved, "samples": checked, "motion": motion}


def _floats(value: Any, shape: tuple[int, ...], name: str) -> npt.NDArray[np.float64]:
    """An array of floats of a shape, of which -1 is any length."""
    found = np.asarray(value)
    fits = found.ndim == len(shape) and all(
        wanted in (-1, length) for wanted, length in zip(shape, found.shape, strict=True)
    )
    if not fits or found.dtype.kind not in "fiu":
        raise _misfit(name, found, shape)
    return np.ascontiguousarray(found, np.float64)


def _misfit(name: str, found: npt.NDArray[Any], shape: tuple[int, ...]) -> InputError:
    return InputError(
        f"the array {name} of the file has the shape {found.shape} and numbers of type "
        f"{found.dtype}, where the machine has {shape}: the file is damaged, or was made by hand."
    )

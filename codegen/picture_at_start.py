"""The picture of a declared mechanism before anything is built, at its start or its guesses."""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.assembled_start import assembled_start
from codegen.derive.equations import derive
from codegen.drawing.body_outlines import complete_picture
from codegen.drawing.picture import Picture
from codegen.errors import InputError, note
from codegen.lower.interpreter import FAILURES, evaluate
from codegen.lower.kernels.picture_kernels import CURVES, NAME, lower_picture
from codegen.lower.lowered_scene import lower
from codegen.lower.poses_near_start import FloatArray, Poses
from codegen.reading.scene_selection import valid_scenes, with_settings

if TYPE_CHECKING:
    from codegen.model import Model


def declared_picture(
    model: "Model", scene: Any = None, parameters: Mapping[str, float | str] | None = None,
    assembled: bool = True,
) -> Picture:  # fmt: skip
    """What a declared mechanism looks like at t = 0 and rest; the words are those of `Model.draw`.

    Raises ModelError or SceneError with all problems of the declaration.
    """
    declared = with_settings(model, parameters or {})
    chosen, *_ = valid_scenes(declared, None if scene is None else (scene,))
    lowered = lower(derive(declared, chosen))
    q, title = Poses(lowered).guess, ""
    if assembled:
        try:
            start = assembled_start(lowered)
        except InputError as error:
            title = ": its joints do not close from these guesses"
            note(str(error))
        else:
            q = start.q
            if start.note:
                note(f"{lowered.description.model}/{lowered.description.scene}: {start.note}")
    picture = lower_picture(lowered)
    defaults = [value for _, value, *_ in lowered.description.parameters]
    still: dict[str, Any] = {"q": q.tolist(), "v": [0.0] * len(q), "p": defaults}

    def values(name: str, t: float) -> FloatArray:
        out = evaluate(picture.program, name, {"t": t, **still}, math, FAILURES)["out"]
        return np.array([out[k] for k in range(len(out))], dtype=float)

    numbers = values(NAME, 0.0)[None]
    drawn = picture.layout.picture(np.zeros(1), numbers, partial(values, CURVES)).first
    return complete_picture(replace(drawn, title=f"{drawn.title}{title}"))

"""Companion modules of a scene: located, checked, and built if missing or stale.

Exact derivatives, reduced equations and the picture are generated into files of their own next to
the scene's. A companion belongs to one text of that file, whose SHA-256 it names: with any other
the slots of ``p`` might differ, and it is built again.
"""

import re
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError, SupersededError
from codegen.files.generated_modules import (
    check_signature,
    companion_path,
    import_generated,
    read_generated,
    text_hash,
)

if TYPE_CHECKING:
    from codegen import Model, Scene
    from codegen.drawing.picture import Picture
    from runtime.mechanism.mechanism import Mechanism

FloatArray = npt.NDArray[np.float64]
Kind = Literal["tangents", "reduced", "picture"]

_BELONGS = re.compile(r'^MODULE_SHA256 = "([0-9a-f]{64})"$', re.MULTILINE)
_HEADER = 4000  # layout: characters of a generated file, in which its command stands
_UNROLL = re.compile(r"\bunroll(?:=['\"]| )(always|never)\b")  # in the command of the header
_CONTENTS = {
    "tangents": "derivatives", "reduced": "reduced equations", "picture": "picture",
}  # fmt: skip


class Origin(NamedTuple):
    """The source of a loaded machine."""

    model: "Path | Model"  # the model file, or the `Model` of the running program
    scene: "str | Scene"
    path: Path  # the scene's generated file
    digest: str  # SHA-256 of its text


def load_companion(origin: Origin | None, kind: Kind, title: str, path: Path) -> ModuleType:
    """The module that belongs to a loaded machine; built if missing or stale.

    `title` and `path`, the machine's name and its generated file, are for messages. Raises
    AnalysisError if the machine was not loaded from a model, GeneratedFileError if the file was
    edited by hand, or cannot be written, SupersededError if the model has changed since.
    """
    if origin is None:
        raise AnalysisError(
            f"{title} was put together without its model, from {path}, so its {_CONTENTS[kind]} "
            "cannot be built. Load it by runtime.load."
        )
    text = _text(origin, kind)
    if text is not None:
        place = companion_path(origin.path, kind)
        check_signature(place, text, _command(origin, kind))
        return import_generated(place, text_hash(text))
    from codegen import build

    # kernels in loops, or not, as the header of the scene's file says
    unroll = (
        _UNROLL.search(read_generated(origin.path)[:_HEADER]) if origin.path.is_file() else None
    )
    folder, wanted = origin.path.parent, {kind: True, "unroll": unroll[1] if unroll else "auto"}
    (report,) = build(origin.model, origin.scene, folder, compile=False, **wanted).scenes  # type: ignore[arg-type]
    companion = getattr(report, kind)
    if report.digest != origin.digest or companion is None:
        name = origin.scene if isinstance(origin.scene, str) else origin.scene.name
        raise SupersededError(
            f"{origin.path} is {origin.digest[:12]}... in this machine and {report.digest[:12]}... "
            f"now: the model, or the generator, has changed since the machine of scene '{name}' "
            f"was loaded, and its {_CONTENTS[kind]} would be those of another one. Load the "
            "machine again."
        )
    return import_generated(companion.path, companion.digest)


def has_companion(origin: Origin | None, kind: Kind) -> bool:
    """Whether the module that belongs to a loaded machine is built."""
    return origin is not None and _text(origin, kind) is not None


def _text(origin: Origin, kind: Kind) -> str | None:
    """The text of the companion's file, where it belongs to the scene's; else None."""
    place = companion_path(origin.path, kind)
    if not place.is_file():
        return None
    text = read_generated(place)
    belongs = _BELONGS.search(text)
    current = belongs is not None and belongs.group(1) == origin.digest
    has = {"tangents": "def accelerations_tangent(", "reduced": "def reduced_mass("}
    if kind == "picture":
        from codegen.drawing.picture import VERSION

        has["picture"] = f'LAYOUT = "{VERSION}"'
    return text if current and has[kind] in text else None  # else another generator wrote it


def _command(origin: Origin, kind: Kind) -> str:
    """How the user has the companion built anew."""
    if not isinstance(origin.model, Path) or not isinstance(origin.scene, str):
        return f"delete the file, and ask for the {_CONTENTS[kind]} again."
    return (
        f"linkwright build {origin.model} --scene {origin.scene} "
        f"--out {origin.path.parent} --{kind}"
    )


def picture_at_states(
    mechanism: "Mechanism", p: FloatArray, t: FloatArray, q: FloatArray, v: FloatArray
) -> "Picture":
    """The picture in motion at states, without outlines that follow from joints.

    Parameters
    ----------
    mechanism
        Its companion module is built where it is missing.
    p : (np,)
        Parameters, with or without the constants behind them.
    t, q, v : (k,), (k, n), (k, n)
        Instants in s, coordinates and velocities.
    """
    from codegen.drawing.picture import SAMPLES, BodyLayout, Layout, ShapeLayout

    module = load_companion(mechanism.origin, "picture", mechanism.title, mechanism.path)
    bodies = tuple(BodyLayout(*row) for row in module.BODIES)
    rows = tuple(ShapeLayout(*row) for row in module.SHAPES)
    layout = Layout(mechanism.title.replace("/", ", "), bodies, rows)
    numbers = np.zeros((len(t), layout.size))
    q, v = np.ascontiguousarray(q, dtype=float), np.ascontiguousarray(v, dtype=float)
    for k in range(len(t)):
        module.picture(float(t[k]), q[k], v[k], p, numbers[k])
    points = np.zeros((SAMPLES, layout.curves, 2))
    if layout.curves:
        for k, alpha in enumerate(np.linspace(0.0, 2.0 * np.pi, SAMPLES)):
            module.curves(alpha, p, points[k].reshape(-1))
    return layout.picture(t, numbers, list(points.swapaxes(0, 1)))

"""Exact derivatives of a scene's kernels, for implicit methods: found, checked, built if need be.

They stand in a generated file of their own beside the scene's. It belongs to one text of that file,
whose SHA-256 it names: with any other the slots of ``p`` might differ, and it is built anew.
"""

import hashlib
import re
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, NamedTuple

from codegen.artefact import check_signature, import_generated, tangents_path
from codegen.errors import SupersededError
from runtime.kernels import Kernel

if TYPE_CHECKING:
    from codegen import Model, Scene

_BELONGS = re.compile(r'^MODULE_SHA256 = "([0-9a-f]{64})"$', re.MULTILINE)


class Tangents(NamedTuple):
    """The compiled derivatives of a scene, along one direction (dq, dv) a call.

    The fields are called as those of `runtime.integrate.problem.System`, which takes them.

    Attributes
    ----------
    accelerations_tangent
        (t, q, v, p, modes, dq, dv, da): da = (∂a/∂q) dq + (∂a/∂v) dv of what `accelerations`
        answers, the modes held. All of q, v, dq, dv, da have shape (n,), SI units.
    correction_tangent
        (t, q, v, p, w, dq_in, dv_in, dq, dv): the same for both answers of `correction`. At a
        state on the constraints, with w = 0 on the independent coordinates: e_k plus dq along
        (e_k, 0) is the column H e_k of δq = H δq_independent, in which the dependent rows are
        -Φ_u⁻¹ Φ_v (R. A. Wehage and E. J. Haug, Journal of Mechanical Design 104, 1982, 247-255);
        dv along (H e_k, 0) is what that does to the dependent velocities.
    """

    accelerations_tangent: Kernel
    correction_tangent: Kernel


class Origin(NamedTuple):
    """What a loaded machine was made from.

    Attributes
    ----------
    model, scene
        The model file, or the `Model` of the running program, and the scene.
    path, digest
        The scene's generated file, and the SHA-256 of its text.
    """

    model: "Path | Model"
    scene: "str | Scene"
    path: Path
    digest: str


def load_tangents(origin: Origin) -> Tangents:
    """The derivatives that belong to a loaded machine; built if missing or stale.

    Raises
    ------
    GeneratedFileError
        If the file was edited by hand, or cannot be written.
    SupersededError
        If the model has changed since the machine was loaded.
    """
    path = tangents_path(origin.path)
    if path.is_file():
        text = path.read_text(encoding="utf-8")
        check_signature(path, text, _command(origin))
        belongs = _BELONGS.search(text)
        if belongs is not None and belongs.group(1) == origin.digest:
            return _gather(import_generated(path, hashlib.sha256(text.encode()).hexdigest()))
    from codegen import build

    report = build(
        origin.model, origin.scene, origin.path.parent, tangents=True, compile=False
    ).scenes[0]
    name = origin.scene if isinstance(origin.scene, str) else origin.scene.name
    if report.digest != origin.digest or report.tangents is None:
        raise SupersededError(
            f"{origin.path} is {origin.digest[:12]}... in this machine and {report.digest[:12]}... "
            f"now: the model, or the generator, has changed since the machine of scene '{name}' "
            "was loaded, and its derivatives would be those of another one. Load the machine again."
        )
    return _gather(import_generated(report.tangents.path, report.tangents.digest))


def _command(origin: Origin) -> str:
    if not isinstance(origin.model, Path) or not isinstance(origin.scene, str):
        return "delete the file, and ask for the derivatives again."
    return (
        f"python -m codegen build {origin.model} --scene {origin.scene} "
        f"--out {origin.path.parent} --tangents"
    )


def _gather(module: ModuleType) -> Tangents:
    return Tangents(*(getattr(module, name) for name in Tangents._fields))

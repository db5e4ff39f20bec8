"""Forms that draw bodies in space: extruded outlines, and meshes out of files."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from codegen.declare.drawn_pose import attitude_of_axes, rotation_of
from codegen.declare.outline_files import drawing_file
from codegen.declare.outlines import Outline, numbers_of, polygon
from codegen.drawing.meshes import MOST, Mesh, prism
from codegen.errors import ModelError, module_of_extra
from codegen.readers.calls import declaring
from codegen.readers.quantities import UnitError, converted, finite_in_unit
from codegen.readers.values import KindError, members, shown

LARGEST = 1e9  # safety: m; forms that reach farther are not drawn
ORIGIN, PLANE = (0, 0, 0), ((1, 0, 0), (0, 1, 0))


@declaring("extruded")
def extruded(outline: Any, thickness: Any, at: Any = ORIGIN, axes: Any = PLANE) -> Mesh:
    """A plate or a rod with an outline, as the form of a body in space.

    Parameters
    ----------
    outline
        `polygon`, `disc`, `rectangle`, `bar`, what `read_outline` returns, each with holes, or the
        corners of a polygon, m; without parameters.
    thickness
        In m, half of it on either side of the outline's plane.
    at, axes
        The place of the outline's origin, m, and the directions of its x and y axes, in the frame
        of the body.
    """
    whole = outline if isinstance(outline, Outline) else polygon(outline)
    try:
        height = finite_in_unit(thickness, "m")
    except UnitError:
        height = None
    if height is None or not 0.0 < height < LARGEST:
        size = f"more than 0 m, up to {LARGEST:.0e} m"
        raise ModelError(f"thickness is {shown(thickness)}; give a length of {size}.")
    try:
        loops = [numbers_of(tuple(loop), {}) for loop in (whole, *whole.holes)]
    except KindError as error:
        raise ModelError("the outline of a form contains parameters; give numbers.") from error
    if not all(np.abs(loop).max() < LARGEST for loop in loops):
        raise ModelError(f"the outline of a form has a corner that is not within {LARGEST:.0e} m.")
    return _placed(prism(loops, height), at, axes)


@declaring("read_mesh")
def read_mesh(file: str | Path, unit: str, at: Any = ORIGIN, axes: Any = PLANE) -> Mesh:
    """The surface in an STL or OBJ file, as the form of a body in space; it has no mass.

    trimesh reads the file. Where the file has changed, models that read it are built again.

    Parameters
    ----------
    file
        Its path ends in ``.stl`` or ``.obj``; model files write ``Path(__file__).parent / name``.
    unit
        Of the file's numbers, such as ``"mm"``: these files do not say it.
    at, axes
        As of `extruded`.
    """
    path = drawing_file(file, (".stl", ".obj"))
    try:
        scale = float(converted(1.0, unit, "m"))
    except UnitError as misfit:
        raise ModelError(f"{path.name}, unit: {misfit}") from misfit
    reader = module_of_extra("trimesh", "meshes", "Meshes need trimesh")
    text = path.read_bytes() if path.suffix.lower() == ".obj" else b""
    if zero := re.search(rb"(?m)^f\b[^\n#]*[ \t]0(?!\d)", text):  # trimesh takes the last vertex
        raise ModelError(
            f"{path.name}, line {len(text[: zero.end()].splitlines())}: a face has the vertex 0; "
            "OBJ files count vertices from 1. Export the file anew."
        )
    try:
        read = reader.load_mesh(path, file_type=path.suffix.lower()[1:], process=False)
        vertices, faces = np.asarray(read.vertices, float), np.asarray(read.faces)
    except Exception as error:  # the readers of trimesh raise many kinds
        # what is neither binary nor UTF-8 it hands to another package, which need not be there
        reason = "it is damaged, or cut off" if isinstance(error, ImportError) else error
        raise ModelError(f"{path.name} cannot be read: {reason}") from error
    lost = np.isin(faces, np.flatnonzero(~np.isfinite(vertices).all(axis=1))).any(axis=-1)
    if lost.any():
        raise ModelError(
            f"{path.name}: triangle {lost.argmax() + 1} has a corner that is not finite. Export "
            "the file anew."
        )
    corners, numbers = np.unique(scale * vertices, axis=0, return_inverse=True)
    faces = numbers.ravel()[faces] if len(faces) else faces
    a, b, c = faces.T if len(faces) else (faces,) * 3
    faces = faces[(a != b) & (b != c) & (c != a)] if len(faces) else faces
    if not len(faces) or not np.abs(corners).max() < LARGEST:
        raise ModelError(
            f"{path.name} has {len(faces)} triangles with an area, and corners to "
            f"{np.abs(corners).max(initial=0.0):.3g} m; give a file that has triangles within "
            f"{LARGEST:.0e} m."
        )
    if len(faces) > MOST:
        raise ModelError(
            f"{path.name} has {len(faces)} triangles; give a file with 1 to {MOST}, for which a "
            "page has room: trimesh's simplify_quadric_decimation writes one."
        )
    return _placed(Mesh(corners, faces), at, axes)


def _placed(mesh: Mesh, at: Any, axes: Any) -> Mesh:
    try:
        origin, x, y = (
            np.array([finite_in_unit(c, "m") for c in members(one, 3)], dtype=float)
            for one in (at, *members(axes, 2))
        )
        attitude = attitude_of_axes(x, y) if np.abs(origin).max() < LARGEST else None
    except KindError:
        attitude = None
    if attitude is None:
        raise ModelError(
            f"at is {shown(at)}, axes is {shown(axes)}; give a place, three numbers, and two "
            "directions that are not parallel."
        )
    return Mesh(origin + mesh.vertices @ rotation_of(attitude).T, mesh.triangles)

"""Joints in space whose vectors are opposite: h_i × h_j = 0 holds for these, too."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import AssemblyError
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.module_tables import Description
from runtime.mechanism.spins import rotation_matrices


def _facing(description: Description, q: FloatArray) -> Iterator[tuple[str, Any]]:
    """Joints with the products of vectors that face each other, (...), at positions q, (..., n)."""
    for joint, i, of_i, j, of_j in description.facing:
        vectors = (
            rotation_matrices(q[..., k : k + 4]) @ vector if k >= 0 else vector
            for k, vector in ((i, of_i), (j, of_j))
        )
        yield joint, np.sum(np.multiply(*vectors), axis=-1)


def are_mirrored(description: Description, q: FloatArray) -> npt.NDArray[np.bool_]:
    """Whether any joint has opposite vectors at positions q, (r, n); (r,)."""
    return sum((products < 0.0 for _, products in _facing(description, q)), np.zeros(len(q))) > 0


def mirrored_joints(description: Description, q: FloatArray, *, keeping: bool = False) -> list[str]:
    """Joints whose vectors are opposite at q, (n,); `keeping`: those that keep an attitude."""
    found = dict.fromkeys(joint for joint, product in _facing(description, q) if product < 0.0)
    named = [row[0] for row in description.facing]
    return [joint for joint in found if not keeping or named.count(joint) > 1]


def mirror_note(description: Description, q: FloatArray) -> str:
    """A sentence on mirrored joints at q, (n,); AssemblyError of those that keep an attitude."""
    if joints := mirrored_joints(description, q, keeping=True):
        raise AssemblyError(
            f"{description.title}: joint '{joints[0]}' closes with its bodies turned by half a "
            "turn against the drawing, since its equations hold there, too. Give a guess of the "
            "bodies' Euler parameters nearer to the drawing."
        )
    joints = mirrored_joints(description, q)
    return bool(joints) * (
        f"The axes of the two bodies are opposite in {', '.join(joints)}. If one direction is "
        "meant, give a guess of the bodies' Euler parameters nearer to it."
    )

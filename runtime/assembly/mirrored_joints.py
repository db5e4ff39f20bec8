"""Joints in space whose vectors are opposite: h_i × h_j = 0 holds for these, too."""

import numpy as np

from codegen.errors import AssemblyError
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.module_tables import Description
from runtime.mechanism.spins import rotation_matrices


def mirrored_joints(description: Description, q: FloatArray, *, keeping: bool = False) -> list[str]:
    """Joints whose vectors are opposite at q, (n,); `keeping`: those that keep an attitude."""

    def turned(column: int, vector: tuple[float, ...]) -> FloatArray:
        return rotation_matrices(q[column : column + 4]) @ vector if column >= 0 else vector  # type: ignore[return-value]

    found = {
        joint: None for joint, i, of_i, j, of_j in description.facing
        if np.dot(turned(i, of_i), turned(j, of_j)) < 0.0
    }  # fmt: skip
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

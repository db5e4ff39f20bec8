"""What a scene reports beside the motion, and what it could."""

from dataclasses import dataclass

from codegen.declare.scene import Scene
from codegen.model import Model
from codegen.model.outputs import GROUPS


@dataclass(frozen=True)
class OutputEntry:
    """A word of ``outputs=``, whether the scene has it, and why."""

    name: str
    asked: bool
    why: str


def outputs(model: Model, scene: Scene) -> tuple[OutputEntry, ...]:
    """The groups of outputs, and those of single elements that the scene names."""
    if scene.analysis == "kinematics":
        reason = "a kinematic scene has no masses and no forces"
        return tuple(OutputEntry(word, False, reason) for word in GROUPS)
    found = []
    for word in GROUPS:
        if scene.outputs is None:
            still = scene.analysis == "equilibrium" and word == "powers"
            why = (
                "a scene for equilibrium has no motion" if still else "everything is, unless named"
            )
            found.append(OutputEntry(word, not still, why))
        else:
            asked = word in scene.outputs
            why = "named by the scene" if asked else "the scene does not name it"
            found.append(OutputEntry(word, asked, why))
    single = [word for word in scene.outputs or () if word not in GROUPS]
    return (*found, *(OutputEntry(word, True, "named by the scene") for word in single))

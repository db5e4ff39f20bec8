"""What a scene reports beside the motion, and what it could."""

from dataclasses import dataclass

from codegen.declare.scene import Scene
from codegen.model import Model
from codegen.model.outputs import ALL, GROUPS


@dataclass(frozen=True)
class OutputEntry:
    """A word of ``outputs=``, whether the scene has it, and why."""

    name: str
    asked: bool
    why: str


def outputs(model: Model, scene: Scene) -> tuple[OutputEntry, ...]:
    """The groups of outputs, and those of single elements that the scene names."""
    found = []
    for word in GROUPS:
        told = word in ALL if scene.outputs is None else word in scene.outputs
        why = "named by the scene" if told else "the scene does not name it"
        if scene.outputs is None:
            why = "reported where no output is named" if told else "not reported unless named"
        if scene.analysis == "kinematics" and word != "paths":
            told, why = False, "a kinematic scene has no masses and no forces"
        elif scene.analysis == "equilibrium" and word in ("powers", "works"):
            told, why = False, "a scene for equilibrium has no motion"
        found.append(OutputEntry(word, told, why))
    single = [word for word in scene.outputs or () if word not in GROUPS]
    return (*found, *(OutputEntry(word, True, "named by the scene") for word in single))

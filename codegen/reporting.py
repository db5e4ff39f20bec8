"""What is wrong with the outputs that one scene asks for."""

from collections.abc import Iterator

from codegen.declare.scene import Scene
from codegen.derive.equations import active_joints
from codegen.model import Model
from codegen.model.outputs import ONE


def output_problems(model: Model, scene: Scene) -> Iterator[str]:
    """Outputs that need what the scene leaves out; each says what, and how to have it."""
    where = f"scene '{scene.name}'"
    joints = active_joints(model, scene)
    for word in scene.outputs or ():
        if scene.analysis == "kinematics":
            yield (
                f"{where}: the output '{word}' needs masses and forces, which a kinematic scene "
                "leaves out; declare it with analysis='dynamics', or leave the output out."
            )
            continue
        if scene.analysis == "equilibrium" and word.startswith("power"):
            yield (
                f"{where}: the output '{word}' needs a motion, which a scene for equilibrium "
                "leaves out; declare it with analysis='dynamics', or leave the output out."
            )
        match = ONE.match(word)
        if match is None or match[2] in (*joints, *scene.drivers, *scene.effects):
            continue
        kind = model.kind(match[2])
        wanted = f"{kind}s" if kind in ("effect", "driver") else "bodies and joints"
        yield (
            f"{where}: the output '{word}' needs {kind} '{match[2]}', which the scene leaves out; "
            f"take '{match[2]}' in among its {wanted}, or leave the output out."
        )

"""Checks of the outputs of a scene."""

from collections.abc import Iterator

from codegen.declare.scene import Scene
from codegen.derive.constraints import constraint_terms
from codegen.derive.effects import effect_terms
from codegen.derive.equations import active_joints
from codegen.model import Model
from codegen.model.outputs import ONE


def output_problems(model: Model, scene: Scene) -> Iterator[str]:
    """Outputs that need elements which the scene leaves out, and how to get them."""
    where = f"scene '{scene.name}'"
    joints = active_joints(model, scene)
    for word in scene.outputs or ():
        if scene.analysis == "kinematics" and not word.startswith("path"):
            yield (
                f"{where}: the output '{word}' needs masses and forces, which a kinematic scene "
                "leaves out; declare it with analysis='dynamics', or leave the output out."
            )
            continue
        if scene.analysis == "equilibrium" and word.startswith(("power", "work")):
            yield (
                f"{where}: the output '{word}' needs a motion, which a scene for equilibrium "
                "leaves out; declare it with analysis='dynamics', or leave the output out."
            )
        match = ONE.match(word)
        if match is None:
            continue
        group, name = match.groups()
        if name in (*joints, *scene.drivers, *scene.effects):
            yield from _nothing_there(model, scene, where, group, name)
            continue
        if group == "path":
            yield from _no_body(model, scene, where, name)
            continue
        kind = model.kind(name)
        group_names = f"{kind}s" if kind in ("effect", "driver") else "bodies and joints"
        yield (
            f"{where}: the output '{word}' needs {kind} '{name}', which the scene leaves out; "
            f"take '{name}' in among its {group_names}, or leave the output out."
        )


def _no_body(model: Model, scene: Scene, where: str, name: str) -> Iterator[str]:
    """A point whose body takes no part, or that the scene leaves out itself."""
    (body,) = model.effects[name].bodies
    gone = name if body.name in scene.bodies else body.name
    kind = "point" if gone == name else model.kind(gone)
    yield (
        f"{where}: the output 'path({name})' needs {kind} '{gone}', which the scene leaves out; "
        f"take '{gone}' in, or leave the output out."
    )


def _nothing_there(model: Model, scene: Scene, where: str, group: str, name: str) -> Iterator[str]:
    """Reactions and powers that an element which acts does not have."""
    output = f"{group}({name})"
    if name not in scene.effects:
        element = model.joints.get(name) or model.drivers[name]
        moving = name in scene.drivers or any(nu != 0 for nu in constraint_terms(element)[1].nu)
        if group in ("power", "work") and not moving:
            yield (
                f"{where}: there is no output '{output}', as {element.kind} '{name}' does no work; "
                "leave it out."
            )
        return
    effect = model.acting(scene)[name]
    terms = effect_terms(effect, tuple(model.bodies[b] for b in scene.bodies))
    working = bool(terms.loads or terms.pulls or terms.friction)
    if group == "work" and not (working or terms.potential is not None):
        yield f"{where}: there is no output '{output}', as '{name}' exerts nothing; leave it out."
    if group == "power" and not working:
        yield (
            f"{where}: there is no output '{output}', as all that {effect.kind} '{name}' does has "
            "a potential; ask for 'energy'."
        )
    if group == "reaction" and not (terms.reported or terms.friction):
        yield (
            f"{where}: there is no output '{output}', as {effect.kind} '{name}' reports no force; "
            "leave it out."
        )

"""Checks of the outputs of a scene."""

from collections.abc import Iterator

from codegen.declare.element import EXERTED, QUANTITIES, label
from codegen.declare.scene import Scene
from codegen.derive.constraint_terms import constraint_terms
from codegen.derive.effect_terms import available_quantities, effect_measures, effect_terms
from codegen.derive.equations import active_joints
from codegen.model import Model
from codegen.model.scene_requests import ONE

GEOMETRY = ("point", *(word for word in QUANTITIES if word not in EXERTED))


def output_problems(model: Model, scene: Scene) -> Iterator[str]:
    """Outputs that need elements which the scene leaves out, and how to get them."""
    where = f"scene '{scene.name}'"
    acting = (*active_joints(model, scene), *scene.drivers, *scene.effects)
    leave = "or leave the output out."
    for word in scene.outputs or ():
        if scene.analysis == "kinematics" and not word.startswith(GEOMETRY):
            yield (
                f"{where}: the output '{word}' needs masses and forces, which a kinematic scene "
                f"leaves out; declare it with analysis='dynamics', {leave}"
            )
            continue
        if scene.analysis == "equilibrium" and word.startswith(("power", "work")):
            yield (
                f"{where}: the output '{word}' needs a motion, which a scene for equilibrium "
                f"leaves out; declare it with analysis='dynamics', {leave}"
            )
        match = ONE.match(word)
        if match is None:
            continue
        group, name = match.groups()
        if name in acting:
            if reason := _missing_output(model, scene, group, name):
                yield f"{where}: there is no output '{word}', as {reason}"
            continue
        if group == "point":  # the point's body takes no part, or the scene leaves out the point
            (body,) = model.effects[name].bodies
            gone = name if body.name in scene.bodies else body.name
            kind, advice = "point" if gone == name else model.kind(gone), f"take '{gone}' in"
        else:
            gone, kind = name, model.kind(name)
            others = f"{kind}s" if kind in ("effect", "driver") else "bodies and joints"
            advice = f"take '{gone}' in among its {others}"
        yield (
            f"{where}: the output '{word}' needs {kind} '{gone}', which the scene leaves out; "
            f"{advice}, {leave}"
        )


def _missing_output(model: Model, scene: Scene, group: str, name: str) -> str | None:
    """Why an element that acts has no such reaction, power or work."""
    if name not in scene.effects:
        if group in QUANTITIES:
            return f"'{name}' is no effect; ask for 'reaction({name})'."
        element = model.joints.get(name) or model.drivers[name]
        moving = name in scene.drivers or any(nu != 0 for nu in constraint_terms(element)[1].nu)
        idle = group in ("power", "work") and not moving
        return f"{label(element)} does no work; leave it out." if idle else None
    effect, bodies = model.acting(scene)[name], tuple(model.bodies[b] for b in scene.bodies)
    terms = effect_terms(effect, bodies)
    if group in QUANTITIES:
        measures = effect_measures(effect, terms, bodies)
        if group in (known := available_quantities(terms, measures)):
            return None
        words = " or ".join(f"'{q}({name})'" for q in QUANTITIES if q in known)
        return f"{label(effect)} has no {group}; {f'ask for {words}' if words else 'leave it out'}."
    working = bool(terms.loads or terms.pulls or terms.friction)
    if group in ("work", "power") and not (working or terms.potential is not None):
        return f"'{name}' exerts nothing; leave it out."
    if group == "reaction" and not (terms.reported or terms.friction):
        return f"{label(effect)} is no joint; ask for 'force({name})'."
    return None

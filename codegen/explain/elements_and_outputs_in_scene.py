"""What a machine declares, what of it takes part in a scene, and why; the same for outputs."""

from collections.abc import Iterator

from codegen.declare.element import Constraint, Effect
from codegen.declare.return_values.effects import friction_law
from codegen.declare.return_values.elements import bodies_of, replaced_body
from codegen.declare.scene import Scene
from codegen.derive.equations import active_joints
from codegen.explain.ledger_records import OutputEntry, Part
from codegen.model import Model
from codegen.model.base import TRACKED
from codegen.model.bodies import FORMS
from codegen.model.fidelities import NONE
from codegen.model.requested_outputs import ALL, GROUPS, OF_ANALYSIS


class Inventory:
    """The parts of a model, and why each takes part in a scene or does not."""

    def __init__(self, model: Model, scene: Scene) -> None:
        self.model, self.scene = model, scene
        self.how = dict(scene.request.fidelity)
        named = [e for e in scene.request.effects if e not in scene.request.without]
        self.choices = {g: model.choice(g, self.how, named) for g in model.groups}
        self.joints = active_joints(model, scene)

    def parts(self) -> Iterator[Part]:
        """Joints, drivers, effects, then the fidelities, without their costs."""
        yield from map(self._joint, self.model.joints.values())
        for name, driver in self.model.drivers.items():
            acts = name in self.scene.drivers
            reason = self._named if acts else self._absent
            yield Part(name, driver.kind, "driver", acts, reason(name))
        yield from map(self._effect, self.model.effects)
        yield from self._fidelities()

    def _joint(self, joint: Constraint) -> Part:
        name, scene = joint.name, self.scene
        acts = name in self.joints
        stands_for = replaced_body(joint)
        missing = [b.name for b in bodies_of(joint) if b.name not in ("ground", *scene.bodies)]
        if acts:
            why = "its bodies take part"
            if stands_for is not None:
                why = f"'{stands_for.name}' is taken as '{self.how.get(stands_for.name, 'link')}'"
        elif reason := self._other_choice(name):
            why = reason
        elif missing and missing[0] in self.model.couplers and self.how.get(missing[0]):
            why = f"'{missing[0]}' is taken as '{self.how[missing[0]]}'"
        elif missing:
            why = f"unreachable: body '{missing[0]}' takes no part"
        elif stands_for is not None and stands_for.name in scene.bodies:
            why = f"stands for body '{stands_for.name}', which takes part"
        else:
            why = "the scene leaves it out"
        return Part(name, joint.kind, "joint", acts, why)

    def _effect(self, name: str) -> Part:
        scene = self.scene
        effect = self.model.effects[name]
        named = name in scene.effects
        acts = named and (scene.analysis != "kinematics" or effect.kind == TRACKED)
        if acts:
            kind = self.model.acting(scene)[name].kind
            word = f", as '{self.how[name]}'" if name in self.how else ""
            return Part(name, kind, "effect", True, self._named(name) + word)
        why = self._absent(name)
        if named:
            why = "named, but a kinematic scene has no forces"
        elif self.how.get(name) == NONE:
            why = f"the fidelity '{NONE}' is chosen"
        return Part(name, effect.kind, "effect", False, why)

    def _named(self, name: str) -> str:
        """Why an effect or driver acts."""
        if name in (*self.scene.request.effects, *self.scene.request.drivers):
            return "named by the scene"
        for group, choices in self.model.groups.items():
            if name in choices[self.choices[group]]:
                return f"'{self.choices[group]}' of '{group}' is chosen"
        return "needed by an output"

    def _absent(self, name: str) -> str:
        """Why an effect or driver does not act."""
        element = self.model.effects.get(name) or self.model.drivers[name]
        owners = [body.name for body in bodies_of(element) if not body.fixed]
        law = friction_law(element) if isinstance(element, Effect) else None
        owners += [law.joint] if law else []
        lacking = [o for o in owners if o not in (*self.scene.bodies, *self.joints)]
        if reason := self._other_choice(name):
            return reason
        if lacking:
            kind = self.model.kind(lacking[0])
            return f"unreachable: {kind} '{lacking[0]}' takes no part"
        if name in self.scene.request.without:
            return "the scene leaves it out"
        return "the scene does not name it"

    def _other_choice(self, name: str) -> str | None:
        for group, choices in self.model.groups.items():
            chosen = self.choices[group]
            if name not in choices[chosen] and any(name in names for names in choices.values()):
                return f"'{chosen}' of '{group}' is chosen"
        return None

    def _fidelities(self) -> Iterator[Part]:
        for name, forms in self.model.fidelities.items():
            taken = self.model.acting(self.scene).get(name)
            declared = self.model.effects[name]
            whole = next((w for w, form in forms.items() if form is (taken or declared)), None)
            for word, form in forms.items():
                acts = taken is not None and self.scene.analysis != "kinematics" and word == whole
                why = f"'{whole}' is chosen" if taken is not None else f"'{name}' does not act"
                yield self._word(name, word, acts, f"it {form}" if isinstance(form, str) else why)
        chosen = {name: self.how.get(name, FORMS[0]) for name in self.model.couplers} | self.choices
        for name, taken_word in chosen.items():
            for word in dict.fromkeys(self.model.groups.get(name, FORMS)):
                yield self._word(name, word, word == taken_word, f"'{taken_word}' is chosen")

    def _word(self, name: str, word: str, acts: bool, otherwise: str) -> Part:
        """A word that a fidelity may take."""
        taken = "chosen by the scene" if name in self.how else "as declared"
        return Part(f"{name}: {word}", "fidelity", "fidelity", acts, taken if acts else otherwise)


def output_inventory(model: Model, scene: Scene) -> tuple[OutputEntry, ...]:
    """The groups of outputs, and those of single elements that the scene names."""
    entries = []
    for word in GROUPS:
        reported = word in ALL if scene.outputs is None else word in scene.outputs
        why = "named by the scene" if reported else "the scene does not name it"
        if scene.outputs is None:
            why = "reported where no output is named" if reported else "not reported unless named"
        if word not in OF_ANALYSIS[scene.analysis]:
            kinematic = scene.analysis == "kinematics"
            lacks = "a kinematic scene has no masses and no forces"
            reported, why = False, lacks if kinematic else "a scene for equilibrium has no motion"
        entries.append(OutputEntry(word, reported, why))
    single = [word for word in scene.outputs or () if word not in GROUPS]
    return (*entries, *(OutputEntry(word, True, "named by the scene") for word in single))

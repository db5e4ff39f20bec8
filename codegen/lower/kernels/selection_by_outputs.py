"""Selection of the kernels of a scene, and of their rows, by its outputs."""

from codegen.derive.equations import Equations, tracked_points
from codegen.lower.program import Input, dependencies
from codegen.lower.scene_graph import Reaction, SceneGraph


class Selection:
    """The outputs that a scene names; all of them where it names none."""

    def __init__(self, equations: Equations) -> None:
        self.outputs = equations.scene.outputs
        # whether the scene asks how the machine moves under forces, and not only where it rests
        self.moves = equations.scene.analysis == "dynamics"
        # A run holds a friction in a joint that sticks against its limit in each position.
        laws = ((e.name, e.terms.friction) for e in equations.effects)
        self._needed = {name for name, law in laws if law and law.limit is not None}
        self._needed |= set(tracked_points(equations))
        self._massive = bool(equations.mass)

    def energy(self) -> bool:
        """Whether kinetic and potential energy are."""
        return self.outputs is None or "energy" in self.outputs

    def power(self, source: str) -> bool:
        """Whether the power of an effect or driver is."""
        return self.moves and self._one("power", source)

    def balance(self) -> bool:
        """Whether the powers that make a balance with the energies are."""
        return self.moves and (self.outputs is None or "powers" in self.outputs)

    def whole_power(self, source: str) -> bool:
        """Whether a power is that includes what a potential takes, which has to be named."""
        return self.outputs is not None and self.power(source)

    def work(self, source: str) -> bool:
        """Whether the work of an effect or driver is, which has to be named."""
        return self.moves and self.outputs is not None and self._one("work", source)

    def reactions(self, scene: SceneGraph) -> list[Reaction]:
        """The forces that are, of elements that transmit them."""
        return [row for row in scene.reactions if self._reported(row)]

    def _reported(self, row: Reaction) -> bool:
        if "reaction" in row.words and row.element in self._needed:
            return True
        asked = (self._one(word, row.element) for word in row.words if word != "reaction")
        if self.outputs is not None and any(asked):
            return True
        return "reaction" in row.words and self._massive and self._one("reaction", row.element)

    def multipliers(self, scene: SceneGraph) -> tuple[int, ...]:
        """Constraints on whose multipliers an output depends; all where none is named."""
        if self.outputs is None:
            return tuple(range(scene.m))
        values = [row.value for row in self.reactions(scene)]
        values += [value for name, value in scene.powers if self.power(name) or self.work(name)]
        literals = (scene.graph.values[k].literal for k in dependencies(scene.graph.values, values))
        needed = {x.slot for x in literals if isinstance(x, Input) and x.array == "lam"}
        for row, name in enumerate(scene.owners):
            if scene.nu[row] != scene.graph.zero and (self.power(name) or self.work(name)):
                needed.add(row)
        return tuple(sorted(needed))

    def _one(self, group: str, element: str) -> bool:
        names = self.outputs
        return names is None or f"{group}s" in names or f"{group}({element})" in names

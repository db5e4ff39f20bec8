"""Selection of the kernels of a scene, and of their rows, by its outputs."""

from codegen.derive.equations import Equations, tracked_points
from codegen.lower.program import Input
from codegen.lower.scene_graph import SceneGraph
from codegen.lower.substitution import dependencies


class Selection:
    """The outputs that a scene names; all of them where it names none."""

    def __init__(self, equations: Equations) -> None:
        self.outputs = equations.scene.outputs
        # whether the scene asks how the machine moves under forces, and not only where it rests
        self.moves = equations.scene.analysis == "dynamics"
        # A run holds a friction in a joint that sticks against its limit in each position.
        self._needed = {e.name for e in equations.effects if _limited(e.terms.friction)}
        self._needed |= set(tracked_points(equations))
        self._massive = bool(equations.mass)

    def energy(self) -> bool:
        """Whether kinetic and potential energy are."""
        return self.outputs is None or "energy" in self.outputs

    def reaction(self, element: str) -> bool:
        """Whether the forces that an element transmits are."""
        return element in self._needed or (self._massive and self._one("reaction", element))

    def reported(self, scene: SceneGraph) -> tuple[int, ...]:
        """Numbers of the reactions that the scene reports, in order."""
        return tuple(k for k, (name, *_) in enumerate(scene.reactions) if self.reaction(name))

    def power(self, source: str) -> bool:
        """Whether the power of an effect or driver is."""
        return self.moves and self._one("power", source)

    def work(self, source: str) -> bool:
        """Whether the work of an effect or driver is, which has to be named."""
        return self.moves and self.outputs is not None and self._one("work", source)

    def _one(self, group: str, element: str) -> bool:
        if self.outputs is None:
            return True
        return f"{group}s" in self.outputs or f"{group}({element})" in self.outputs


def _limited(friction: object) -> bool:
    return friction is not None and getattr(friction, "limit", None) is not None


def recovered(scene: SceneGraph, selection: Selection) -> tuple[int, ...]:
    """Constraints whose multipliers an output depends on; all rows where `outputs` is None."""
    rows = range(scene.m)
    if selection.outputs is None:
        return tuple(rows)
    values = [value for name, *_, value in scene.reactions if selection.reaction(name)]
    values += [
        value for name, value in scene.powers if selection.power(name) or selection.work(name)
    ]
    literals = (scene.graph.values[k].literal for k in dependencies(scene.graph, values))
    needed = {x.slot for x in literals if isinstance(x, Input) and x.array == "lam"}
    for row, name in enumerate(scene.owners):
        if scene.nu[row] != scene.graph.zero and (selection.power(name) or selection.work(name)):
            needed.add(row)
    return tuple(row for row in rows if row in needed)

"""The arguments of peaked functions of the position, and their rates along the motion."""

from codegen.derive.peaked_functions import PeakedFunction
from codegen.lower.differentiation.derivative_along_motion import Direction
from codegen.lower.program import Kernel, store
from codegen.lower.scene_graph import SceneGraph


def peak_arguments(scene: SceneGraph, peaks: tuple[PeakedFunction, ...]) -> Kernel:
    """The kernel that a run calls in each step; see `codegen.derive.peaked_functions`."""
    graph = scene.graph
    velocities = dict(zip(scene.q, scene.v, strict=True))
    motion = Direction(graph, {**velocities, scene.time: graph.one}, order=1)
    arguments, rates = list[int](), list[int]()
    for peak in peaks:
        (argument,) = scene.credited(peak.element, peak.argument)
        with graph.serving(peak.element):
            rates.append(motion.jet(argument).first.value())
        arguments.append(argument)
    notes = [f"{peak.element}: {peak.kind}" for peak in peaks]
    outputs = store("u", arguments, notes) + store("rate", rates, notes)
    summary = "Arguments u of peaked functions of the position, as in PEAKS, and du/dt."
    return Kernel("peak_arguments", summary, ("t", "q", "v", "p", "modes", "u", "rate"), outputs)

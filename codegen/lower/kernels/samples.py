"""The samples of the values that clocks renew, and the clocks."""

import sympy

from codegen.lower.program import Kernel, storing
from codegen.lower.scene_graph import SceneGraph
from codegen.lower.sympy_translation import Translator
from codegen.readers.failures import errors_at

NEW, KEPT = sympy.symbols("new kept", cls=sympy.Dummy, real=True)


def sampling_kernels(scene: SceneGraph) -> list[Kernel]:
    """The kernels `samples` and `clocks`, of scenes that have sampled values.

    `samples` takes in `modes` which of them are due, 1 or 0. A value is computed from those that
    are due at the same instant and stand before it, unless these have a delay; the kernel asks
    whether one that is a parameter is 0. Conditions are compared, since nothing is integrated
    across a sample.
    """
    graph, states = scene.graph, scene.equations.sampled
    if not states:
        return []
    translate = Translator(graph, scene.translate.environment, None)
    values, clocks = list[int](), list[int]()
    for k, state in enumerate(states):
        with graph.serving(state.name), errors_at(f"sampled value '{state.name}'"):
            value = now = scene.translate.environment[state.symbol]
            if state.sample is not None:
                value = graph.select(graph.mode(k), translate(state.sample), now)
            clocks += [scene.translate(state.every), scene.translate(state.delay)]
        values.append(value)
        if not state.delay.is_number:  # a parameter, which may be 0
            acts = sympy.Piecewise((NEW, state.delay <= 0), (KEPT, True))
            value = translate.scoped({NEW: value, KEPT: now})(acts)
        if not state.delay.is_number or state.delay == 0:
            translate = translate.scoped({state.symbol: value})
    names = [state.name for state in states]
    summary = "Samples of SAMPLED; those that are not due, modes 0, keep their values."
    times = [f"{name}: {word}, s" for name in names for word in ("period", "delay")]
    return [
        storing("samples", summary, "t q v p modes out", values, names),
        storing("clocks", "Period and delay of each of SAMPLED.", "p out", clocks, times),
    ]


def watching_kernels(scene: SceneGraph) -> list[Kernel]:
    """The kernel `watched`, of scenes with conditions that a run watches: 1 where one holds."""
    values, names = list[int](), list[str]()
    for effect in scene.equations.effects:
        if effect.terms.watched is not None:
            with scene.graph.serving(effect.name), errors_at(f"condition '{effect.name}'"):
                values.append(scene.translate(effect.terms.watched))
            names.append(effect.name)
    if not values:
        return []
    summary = "1 where a condition of WATCHED holds, else 0."
    return [storing("watched", summary, "t q v p modes out", values, names)]

"""The kernel of the outputs that follow from accelerations and from other outputs."""

from collections.abc import Iterator, Sequence

from codegen.declare.symbols import Acceleration, ResultSeries, dotted, kinds
from codegen.errors import ModelError
from codegen.lower.program import Kernel, Output
from codegen.lower.scene_graph import Reaction, SceneGraph
from codegen.lower.sympy_translation import Translator
from codegen.readers.values import nearest


def derived_rows(scene: SceneGraph, reported: Sequence[Reaction]) -> Iterator[Reaction]:
    """The derived outputs of a scene, which stand behind the `reported` rows of REACTIONS.

    Nothing is integrated across them, so that conditions are compared; joints that do not act
    exert nothing. ModelError with all that an expression contains and the scene does not have.
    """
    graph, equations, environment = scene.graph, scene.equations, scene.translate.environment
    known, inactive = dict[str, int](), equations.scene.inactive_joints
    for k, row in enumerate(reported):
        name = f"{row.element}.{row.component}"
        known[name] = graph.input("reaction", k, name.replace(".", "_"))
    for q in equations.coordinates if equations.scene.analysis != "equilibrium" else ():
        known[f"a({dotted(q)})"] = environment[Acceleration(f"{q.rate.name}_rate", real=True)]
    for name, expression, unit in equations.derived:
        element, _, component = name.partition(".")
        symbols = {ResultSeries(series, real=True): k for series, k in known.items()}
        idle = (s for s in kinds(expression, ResultSeries) if s.owner in inactive)
        symbols |= dict.fromkeys(idle, graph.zero)
        if missing := expression.free_symbols - {*symbols, *environment}:
            where = f"scene '{equations.scene.name}', output '{element}': the scene has no"
            names = sorted(s.name if "." in s.name else dotted(s) for s in missing)
            raise ModelError(f"{where} '{one}'; {nearest(one, known)}" for one in names)
        with graph.serving(element):
            known[name] = Translator(graph, environment, None).scoped(symbols)(expression)
        yield Reaction(element, component, unit, known[name])


def derived_kernel(rows: Sequence[Reaction], first: int) -> Kernel:
    """The kernel that writes them behind the `first` rows of REACTIONS, which it reads."""
    named = ((row.value, " ".join(filter(None, row[:3]))) for row in rows)
    outputs = (Output("reaction", first + k, *one) for k, one in enumerate(named))
    summary = "The rows of REACTIONS that follow from accelerations and from the other rows."
    return Kernel("derived_outputs", summary, (*"tqvap", "reaction"), tuple(outputs))

"""Outputs by expressions: accelerations of points, reactions in global axes, a modeller's own."""

from collections.abc import Iterable, Iterator

from codegen.declare.element import Effect, JointReaction, Measure, Statement
from codegen.declare.scene import ExpressionOutput, Scene
from codegen.declare.symbols import ResultSeries
from codegen.derive.effect_terms import measured
from codegen.derive.switching_functions import rate


def derived_outputs(
    scene: Scene, joints: Iterable[tuple[str, Statement]], points: Iterable[Effect]
) -> Iterator[ExpressionOutput]:
    """The derived outputs of a scene, each behind those that it contains."""
    asked = {symbol.name for one in scene.expressions for symbol in one.series}
    asked.update(scene.outputs or ())
    for point in points if scene.analysis != "equilibrium" else ():
        velocity = dict(zip("xyz", vars(point)["point"].velocity, strict=False))
        names = {f"{point.name}.a{c}": v for c, v in velocity.items()}
        if asked & {"accelerations", f"acceleration({point.name})", *names}:
            for name, v in names.items():
                yield ExpressionOutput(name, rate(v), "m/s^2")
    for name, statement in joints:
        x, y = f"{name}.global_fx", f"{name}.global_fy"
        reaction, words = statement.reaction, {"global_reactions", f"global_reaction({name})", x, y}
        if isinstance(reaction, JointReaction) and asked & words:
            ux, uy = (e.xreplace(statement.bindings) for e in reaction.direction)
            fx, fy = (ResultSeries(f"{name}.{part}", real=True) for part in ("fx", "fy"))
            yield ExpressionOutput(x, ux * fx - uy * fy, "N")
            yield ExpressionOutput(y, uy * fx + ux * fy, "N")
    for one in scene.expressions:
        yield one._replace(expression=measured(Measure("", "", "", one.expression)).value)

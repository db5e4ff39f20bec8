"""The kernels of a scene's picture: numbers of its shapes, and points of its curves."""

from dataclasses import fields
from typing import Any, NamedTuple

from codegen.derive.scene_picture import BodyNumber, PlaneCurve, Scoped, Slope
from codegen.drawing.picture import BodyLayout, Layout, ShapeLayout, Symbol
from codegen.drawing.shapes import Place, SpacePlace
from codegen.lower.differentiation.gradient import Slopes
from codegen.lower.lowered_scene import Lowered
from codegen.lower.program import Program, storing
from codegen.lower.scene_graph import SceneGraph
from codegen.lower.sympy_translation import Translator

NAME, CURVES = "picture", "curves"


class LoweredPicture(NamedTuple):
    """The program of a picture, and what its numbers mean."""

    program: Program
    layout: Layout


def lower_picture(lowered: Lowered) -> LoweredPicture:
    """Translate the picture of a scene into kernels."""
    return _Lowering(lowered.scene).lowered(
        f"{lowered.description.model}, {lowered.description.scene}"
    )


class _Lowering:
    """Gathers the numbers of a picture."""

    def __init__(self, scene: SceneGraph) -> None:
        self.picture = scene.equations.picture
        self.graph = scene.graph
        known = {s: self.graph.constant(value) for s, value in self.picture.constants}
        # Without switches conditions are compared: a picture knows no modes.
        self.translate = Translator(scene.graph, {**scene.translate.environment, **known}, None)
        self.values: list[int] = []
        self.notes: list[str] = []
        self.curves: list[int] = []
        self.curve_notes: list[str] = []

    def lowered(self, title: str) -> LoweredPicture:
        bodies = tuple(self._body(body) for body in self.picture.bodies)
        rows = tuple(self._shape(row) for row in self.picture.symbols)
        layout = Layout(title, bodies, rows)
        summary = "Numbers of the picture at an instant: poses of bodies, then those of SHAPES."
        kernels = [storing(NAME, summary, "t q v p out", self.values, self.notes)]
        if self.curves:
            about = "x and y of each curve at the parameter α, which t stands for."
            kernels.append(storing(CURVES, about, "t p out", self.curves, self.curve_notes))
        return LoweredPicture(Program(tuple(self.graph.values), tuple(kernels), (), 0.0), layout)

    def _body(self, body: BodyLayout) -> BodyLayout:
        pose = tuple(self._slot(e, f"pose of {body.name}") for e in body.pose)
        note = f"outline of {body.name}"
        outlines = tuple(
            tuple((self._slot(x, note), self._slot(y, note)) for x, y in outline)
            for outline in body.outlines
        )
        return BodyLayout(body.name, body.fixed, pose, outlines)

    def _slot(self, expression: Any, note: str) -> int:
        translate, value = self.translate, expression
        if isinstance(expression, Scoped):
            translate, value = translate.scoped(expression.bindings), expression.expression
        elif isinstance(expression, Slope):
            value = expression.expression
        number = translate(value)
        for q in expression.by if isinstance(expression, Slope) else ():
            along = translate.environment[q]
            slopes = Slopes(self.graph, [along]).gradient({number: self.graph.one})
            number = slopes.get(along, self.graph.zero)
        self.values.append(number)
        self.notes.append(note)
        return len(self.values) - 1

    def _shape(self, row: Symbol) -> ShapeLayout:
        with self.graph.serving(row.element):
            entries = tuple(
                self._field(f"{row.element} {f.name}", getattr(row.shape, f.name))
                for f in fields(row.shape)
            )
        return ShapeLayout(row.element, row.kind, row.role, row.shape.kind, entries)

    def _field(self, note: str, value: Any) -> tuple[str, Any]:
        match value:
            case Place() | SpacePlace():
                return "at", (value.body, *(self._slot(e, note) for e in value[1:]))
            case BodyNumber():
                return "body", int(value)
            case PlaneCurve():
                return "curve", (value.body, self._curve(note, value))
            case bool() | str() | None:
                return "word", value
            case tuple() if not isinstance(value, Scoped | Slope):
                return "bodies", tuple(map(int, value))
        return "number", self._slot(value, note)

    def _curve(self, note: str, curve: PlaneCurve) -> int:
        self.curves += [self.translate(e) for e in (curve.x, curve.y)]
        self.curve_notes += [note, note]
        return len(self.curves) // 2 - 1

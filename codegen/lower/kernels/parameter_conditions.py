"""Kernels of what a scene asks of its parameters: the numbers that are judged before each run."""

import sympy

from codegen.lower.program import Kernel, storing
from codegen.lower.scene_graph import SceneGraph
from codegen.readers.failures import errors_at

NAME = "conditions"


def condition_kernels(scene: SceneGraph) -> list[Kernel]:
    """The kernels `conditions` and `profiles`, of scenes that have any."""
    kernels, equations = [], scene.equations
    if equations.conditions:
        values, notes = list[int](), list[str]()
        for one in equations.conditions:
            numbers = one.condition.numbers
            with errors_at(one.element):
                values += [_translated(scene, number) for number in numbers]
            notes += [one.element] * len(numbers)
        summary = "Numbers that CONDITIONS bound and show, in their order."
        kernels.append(storing(NAME, summary, "p out", values, notes))
    if equations.profiles:
        values = []
        for curve in equations.profiles:
            with errors_at(curve.element):
                values += [_translated(scene, e) for e in curve.derivatives]
        notes = [curve.element for curve in equations.profiles for _ in curve.derivatives]
        summary = "x, y and their first and second derivatives by α, which t stands for: PROFILES."
        kernels.append(storing("profiles", summary, "t p out", values, notes))
    return kernels


def _translated(scene: SceneGraph, expression: sympy.Expr) -> int:
    """The value of an expression whose sizes and larger ones are taken of parameters alone."""
    graph = scene.graph
    plain = expression.replace(sympy.Max, _larger).replace(sympy.Min, _smaller)
    translate, known = scene.translate, dict[sympy.Expr, int]()
    for size in sorted(plain.atoms(sympy.Abs), key=lambda e: (e.count_ops(), str(e))):
        inside = (translate.scoped(known) if known else translate)(size.args[0])
        known[size] = graph.power(graph.mul(inside, inside), 0.5)
    return (translate.scoped(known) if known else translate)(plain)


def _larger(*terms: sympy.Expr) -> sympy.Expr:
    first, *rest = terms
    other = _larger(*rest) if len(rest) > 1 else rest[0]
    return (first + other + sympy.Abs(first - other)) / 2


def _smaller(*terms: sympy.Expr) -> sympy.Expr:
    return -_larger(*(-term for term in terms))

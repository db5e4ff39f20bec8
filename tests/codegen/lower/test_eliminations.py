"""Substitution in a graph, coordinates given outright, loops in closed form: against numbers."""

import math
from random import Random

import numpy as np
import pytest

from codegen.derive.equations import derive
from codegen.lower.graph import Graph, expand_sine, substitute
from codegen.lower.interpreter import evaluate
from codegen.lower.lowered_scene import lower
from codegen.lower.poses_near_start import Poses
from codegen.lower.program import Kernel, Op, Program, store
from codegen.reduce.closed_form_loops import find_loops
from codegen.reduce.coordinate_map import CoordinateMap, ExplicitCoordinates
from tests.random_mechanisms import Scales, random_mechanism


def value_of(graph: Graph, number: int, **arguments: object) -> float:
    """A value at given inputs."""
    kernel = Kernel("asked", "", (), store("out", [number], [""]))
    program = Program(tuple(graph.values), (kernel,), (), 0.0)
    found: float = evaluate(program, "asked", arguments, math)["out"][0]
    return found


@pytest.fixture
def graph() -> Graph:
    return Graph()


def coordinates(graph: Graph, count: int) -> list[int]:
    return [graph.input("q", k, f"q_{k}") for k in range(count)]


# Substitution


def test_what_is_put_in_is_folded(graph: Graph) -> None:
    x, y = coordinates(graph, 2)
    product = graph.mul(graph.function(Op.SIN, x), y)
    total = graph.add(product, graph.mul(x, x))
    assert substitute(graph, [product], {x: graph.zero}) == [graph.zero]
    (left,) = substitute(graph, [total], {y: graph.zero})
    assert left == graph.mul(x, x)
    assert substitute(graph, [total], {}) == [total]


def test_what_is_put_in_agrees_with_numbers(graph: Graph) -> None:
    x, y, z = coordinates(graph, 3)
    told = graph.div(
        graph.add(graph.power(x, 1.5), graph.function(Op.ATAN2, y, graph.constant(2.0))),
        graph.add(graph.one, graph.power(graph.function(Op.TANH, graph.sub(x, y)), 2)),
    )
    put = graph.add(graph.mul(z, z), graph.one)
    (there,) = substitute(graph, [told], {x: put})
    for seed in range(5):
        random = Random(seed)
        q = [random.uniform(0.5, 2.0) for _ in range(3)]
        expected = value_of(graph, told, q=[q[2] ** 2 + 1.0, q[1]])
        assert value_of(graph, there, q=q) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("op", [Op.SIN, Op.COS])
@pytest.mark.parametrize("form", ["x+a", "x-a", "a-x", "x+a+b"])
def test_angle_but_for_a_constant_is_turned(graph: Graph, op: Op, form: str) -> None:
    (x,) = coordinates(graph, 1)
    a, b = (graph.input("p", k, name) for k, name in enumerate("ab"))
    angle = {
        "x+a": graph.add(x, a),
        "x-a": graph.sub(x, a),
        "a-x": graph.sub(a, x),
        "x+a+b": graph.add(graph.add(x, a), b),
    }[form]
    found = expand_sine(graph, op, angle)
    inputs = {"q": [0.7], "p": [0.4, -1.1]}
    plain = getattr(math, op.value)(value_of(graph, angle, **inputs))
    assert value_of(graph, found, **inputs) == pytest.approx(plain, rel=1e-15)
    moving = [v for n, v in enumerate(graph.values) if v.op is op and not graph.settled[n]]
    assert graph.values[found].op is not op
    assert all(v.args == (x,) for v in moving)


# Explicit coordinates


def test_chain_of_givens_and_their_rates(graph: Graph) -> None:
    # x1 = 2 sin x0 + t, x2 = 3 x1 + x0², as rows -2 x1 + ... and x2 - ...
    q = coordinates(graph, 3)
    v = [graph.input("v", k, f"v_{k}") for k in range(3)]
    t = graph.input("t", 0, "t")
    two, three = graph.constant(2.0), graph.constant(3.0)
    s, c = graph.function(Op.SIN, q[0]), graph.function(Op.COS, q[0])
    first = graph.sub(graph.add(graph.mul(two, s), t), q[1])
    second = graph.sub(q[2], graph.add(graph.mul(three, q[1]), graph.mul(q[0], q[0])))
    found = ExplicitCoordinates(
        graph,
        q,
        [first, second],
        {
            (0, 0): graph.mul(two, c),
            (0, 1): graph.neg(graph.one),
            (1, 0): graph.neg(graph.mul(two, q[0])),
            (1, 1): graph.neg(three),
            (1, 2): graph.one,
        },
        [graph.neg(graph.one), graph.zero],
        [
            graph.mul(graph.mul(two, s), graph.mul(v[0], v[0])),
            graph.mul(two, graph.mul(v[0], v[0])),
        ],
        frozenset({0}),
        frozenset(),
    )
    assert found.coordinates == [0]
    assert found.rows == {}
    x, rate, now = 0.8, 1.3, 0.2
    inputs = {"q": [x], "v": [rate], "t": now}
    x1 = 2.0 * math.sin(x) + now
    formulas = found.formulas()
    assert value_of(graph, formulas[1], **inputs) == pytest.approx(x1, rel=1e-15)
    assert value_of(graph, formulas[2], **inputs) == pytest.approx(3.0 * x1 + x * x, rel=1e-15)
    slope = 2.0 * math.cos(x)
    bend = -2.0 * math.sin(x) * rate**2
    for column, slopes, shift, bends in (
        (1, slope, 1.0, bend),
        (2, 3.0 * slope + 2.0 * x, 3.0, 3.0 * bend + 2.0 * rate**2),
    ):
        rates = found.rates()[column]
        assert list(rates.slopes) == [0]
        assert value_of(graph, rates.slopes[0], **inputs) == pytest.approx(slopes, rel=1e-14)
        assert value_of(graph, rates.velocity, **inputs) == pytest.approx(shift, rel=1e-14)
        assert value_of(graph, rates.acceleration, **inputs) == pytest.approx(bends, rel=1e-14)


def test_what_must_be_left_is_left(graph: Graph) -> None:
    q = coordinates(graph, 2)
    row = graph.sub(q[0], q[1])
    entries = {(0, 0): graph.one, (0, 1): graph.neg(graph.one)}
    for left in (0, 1):
        found = ExplicitCoordinates(
            graph,
            q,
            [row],
            dict(entries),
            [graph.zero],
            [graph.zero],
            frozenset(),
            frozenset({left}),
        )
        assert found.coordinates == [left]


# Loops


def test_one_equation_for_one_angle_on_both_branches(graph: Graph) -> None:
    # 2 sin q0 + 3.5 sin q1 - 0.4 = 0
    q = coordinates(graph, 2)
    row = graph.add(
        graph.mul(graph.constant(2.0), graph.function(Op.SIN, q[0])),
        graph.sub(
            graph.mul(graph.constant(3.5), graph.function(Op.SIN, q[1])), graph.constant(0.4)
        ),
    )
    (loop,) = find_loops(graph, q, {7: row}, [1], 0, {})
    assert (loop.rows, loop.columns) == ((7,), (1,))
    (angle,) = loop.angles
    assert angle.row == 7
    for side in (1.0, -1.0):
        inputs = {"q": [0.9], "p": [side]}
        s, c = value_of(graph, angle.s, **inputs), value_of(graph, angle.c, **inputs)
        assert s * s + c * c == pytest.approx(1.0, rel=1e-14)
        closed = [0.9, math.atan2(s, c)]
        assert value_of(graph, row, q=closed) == pytest.approx(0.0, abs=1e-15)
        slope = value_of(graph, angle.slope, q=closed, p=[side])
        assert math.copysign(1.0, slope) == side
        assert slope**2 == pytest.approx(value_of(graph, angle.discriminant, **inputs), rel=1e-13)


def test_two_equations_for_two_angles_on_both_branches(graph: Graph) -> None:
    # e(q0) + 1.5 e(q1) - 1.2 e(q2) - (1.7, 0) = 0
    q = coordinates(graph, 3)
    rows = {}
    for i, (op, base) in enumerate(((Op.COS, 1.7), (Op.SIN, 0.0))):
        ends = [graph.function(op, angle) for angle in q]
        rows[i] = graph.total(
            [
                ends[0],
                graph.mul(graph.constant(1.5), ends[1]),
                graph.neg(graph.mul(graph.constant(1.2), ends[2])),
                graph.constant(-base),
            ]
        )
    (loop,) = find_loops(graph, q, dict(rows), [1, 2], 0, {})
    assert set(loop.columns) == {1, 2}
    assert sum(angle.branch is not None for angle in loop.angles) == 1
    seen = set()
    for side in (1.0, -1.0):
        inputs = {"q": [1.1], "p": [side]}
        closed = [1.1, 0.0, 0.0]
        for angle in loop.angles:
            s, c = value_of(graph, angle.s, **inputs), value_of(graph, angle.c, **inputs)
            assert s * s + c * c == pytest.approx(1.0, rel=1e-13)
            closed[angle.column] = math.atan2(s, c)
        for row in rows.values():
            assert value_of(graph, row, q=closed) == pytest.approx(0.0, abs=1e-14)
        seen.add(round(closed[1], 6))
    assert len(seen) == 2


def test_an_own_coordinate_is_solved_for_from_its_own_row_alone(graph: Graph) -> None:
    q = coordinates(graph, 2)
    row = graph.add(graph.function(Op.SIN, q[0]), graph.function(Op.SIN, q[1]))
    assert find_loops(graph, q, {7: row}, [1], 0, {1: 6}) == []
    (loop,) = find_loops(graph, q, {7: row}, [1], 0, {1: 7})
    assert (loop.rows, loop.columns) == ((7,), (1,))


def test_what_is_not_of_the_form_is_left_alone(graph: Graph) -> None:
    q = coordinates(graph, 2)
    sine = graph.function(Op.SIN, q[1])
    assert find_loops(graph, q, {0: graph.add(graph.mul(sine, sine), q[0])}, [1], 0, {}) == []
    assert find_loops(graph, q, {0: graph.add(graph.add(sine, q[1]), q[0])}, [1], 0, {}) == []


def test_an_angle_near_its_dead_centre_all_along_is_kept() -> None:
    """A cam lifts two flat followers: the height of one says little of the cam's angle."""
    mechanism = random_mechanism(3, "cams", "free", scales=Scales())
    model = mechanism.model()
    lowered = lower(derive(model, model.scenes[mechanism.scene]))
    poses = Poses(lowered)
    nearby = poses.along_motion()
    assert len(nearby) == 17
    assert not np.allclose(nearby[8], nearby[16])
    mapping = CoordinateMap(lowered)
    assert "lever0_phi" in (mapping.names[k] for k in mapping.kept)
    assert mapping.loops == []
    flat = [i for i, name in enumerate(mapping.row_names) if name.endswith("normal")]
    assert len(flat) == 2  # the rows that would give it, and leave it at its dead centre
    column = mapping.names.index("lever0_phi")
    for q in nearby:
        rows = [mapping.explicit.rows[mapping.closures[i]] for i in flat]
        entries = poses.values(mapping.graph, [row.entries[column] for row in rows], q)
        assert np.all(np.abs(entries) < 0.2)  # m, of an arm of one


def test_a_loop_that_is_away_from_its_dead_centre_now_and_then_is_solved() -> None:
    mechanism = random_mechanism(2, "parallel", "free", scales=Scales())
    model = mechanism.model()
    lowered = lower(derive(model, model.scenes[mechanism.scene]))
    assert [loop.columns for loop in CoordinateMap(lowered).loops] != []

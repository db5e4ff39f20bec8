"""Counts of the work of lowering grow no faster than the machine."""

from collections.abc import Callable, Iterable

import pytest

from benchmarks.chain import SCENE, chain
from codegen.derive.equations import derive
from codegen.lower.constant_hoisting import with_constants
from codegen.lower.kernels import accelerations as elimination_choice
from codegen.lower.kernels.accelerations import (
    accelerations,
    cheapest_by_structure,
    dynamics_kernel,
    is_large,
)
from codegen.lower.linear.elimination_order import (
    CoordinateOrder,
    CostExceededError,
    PivotOrder,
    Structure,
)
from codegen.lower.lowered_scene import lower
from codegen.lower.operation_count import operations
from codegen.lower.scene_graph import SceneGraph
from codegen.model import Model
from codegen.reading.scene_selection import valid_scenes
from models.hard.n_four_bar import n_four_bar
from models.hard.spring_chain import model as spring_chain


def scene_graph(model: Model, scene: str) -> SceneGraph:
    """The equations of a scene in a graph."""
    (chosen,) = valid_scenes(model, scene)
    return SceneGraph(derive(model, chosen))


def grow_linearly(small: list[int], large: list[int], ratio: float) -> bool:
    """Whether counts grow no faster than a machine, a tenth for its ends allowed."""
    pairs = zip(small, large, strict=True)
    return all(few > 0 and many <= 1.1 * ratio * few for few, many in pairs)


def test_equations_and_elimination_of_a_chain_grow_linearly(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Values of the equations, values of the elimination, offers of pivots, at 20 and 80 bars."""
    offers, offer = [0], PivotOrder._offer

    def counted(order: PivotOrder, *candidate: object) -> None:
        offers[0] += 1
        offer(order, *candidate)  # type: ignore[arg-type]

    monkeypatch.setattr(PivotOrder, "_offer", counted)
    counts = []
    for links in (20, 80):
        offers[0] = 0
        graph = scene_graph(chain(links), SCENE)
        equations = len(graph.graph.values)
        dynamics_kernel(graph, "mixed", tuple(range(graph.m)))
        counts.append([equations, len(graph.graph.values) - equations, offers[0]])
    assert grow_linearly(*counts, ratio=4.0), counts


def tree(depth: int) -> Model:
    """Bars that carry two bars each, `depth` of them one behind the other."""
    model = Model(f"tree_{depth}", gravity=(0, -9.81))
    ends, start = [model.ground.at(0, 0)], {}
    for level in range(depth):
        bars = [model.body(f"bar_{level}_{k}", mass=1.0, inertia=1 / 12) for k in range(2**level)]
        for k, bar in enumerate(bars):
            model.revolute(f"hinge_{level}_{k}", ends[k], bar.at(-0.5, 0))
            start[bar.phi] = -0.3
        ends = [bar.at(0.5, y) for bar in bars for y in (0.1, -0.1)]
    model.scene("let_go", ["gravity"], start=start)
    return model


def test_tree_is_eliminated_from_its_leaves() -> None:
    """The order of a large tree; its operations grow with the bars, however deep they lie."""
    counts = []
    for depth in (6, 8):
        graph = scene_graph(tree(depth), "let_go")
        kernel, strategy = accelerations(graph, tuple(range(graph.m)), spread=1.0)
        assert strategy == "leaves"
        program = with_constants(graph.graph, (kernel,), declared=0)
        counts.append([operations(program, kernel)])
    assert grow_linearly(*counts, ratio=255 / 63), counts


def test_leaf_is_eliminated_whole_before_the_body_that_carries_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of a chain the last bar goes first: x and y with its hinge, then the angle."""
    steps, renew = [], PivotOrder.renew

    def noted(order: PivotOrder, gone: tuple[int, ...], changed: Iterable[int]) -> None:
        steps.append(gone)
        renew(order, gone, changed)

    monkeypatch.setattr(PivotOrder, "renew", noted)
    graph = scene_graph(chain(3), SCENE)
    dynamics_kernel(graph, "leaves", tuple(range(graph.m)))
    names = [*graph.names, *graph.rows]
    assert [[names[u] for u in gone] for gone in steps[1:5]] == [
        ["link_2_x", "hinge_2_x"],
        ["link_2_y", "hinge_2_y"],
        ["link_2_phi"],
        ["link_1_x", "hinge_1_x"],
    ]


@pytest.mark.parametrize(
    ("machine", "scene", "sizes"),
    [(chain, SCENE, (60, 180)), (n_four_bar, "fall", (40, 120)), (n_four_bar, "driven", (40, 120))],
)
def test_whole_lowering_grows_linearly(
    machine: Callable[[int], Model], scene: str, sizes: tuple[int, int],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """Values built, kept or not, operations of kernels, rows looked at for a coordinate."""
    looks, offer = [0], CoordinateOrder._offer

    def counted(order: CoordinateOrder, row: int) -> None:
        looks[0] += 1
        offer(order, row)

    monkeypatch.setattr(CoordinateOrder, "_offer", counted)
    counts = []
    for size in sizes:
        model, looks[0] = machine(size), 0
        (chosen,) = valid_scenes(model, scene)
        lowered = lower(derive(model, chosen))
        kernels = (lowered.kernels[name] for name in ("accelerations", "correction"))
        work = [operations(lowered.program, kernel) for kernel in kernels]
        counts.append([len(lowered.scene.graph.values), *work, looks[0]])
    assert grow_linearly(*counts, ratio=sizes[1] / sizes[0]), counts


@pytest.mark.parametrize(
    ("model", "scene"),
    [(chain(8), SCENE), (chain(30), SCENE), (n_four_bar(8), "fall"), (spring_chain, "struck")],
)
def test_structure_foresees_the_order_of_elimination(model: Model, scene: str) -> None:
    """The order that is cheapest with all values built is the one that the structure tells."""
    graph = scene_graph(model, scene)
    foreseen = cheapest_by_structure(graph)
    assert not is_large(graph)
    assert accelerations(graph, tuple(range(graph.m)), spread=1.0)[1] == foreseen


def test_large_scene_builds_one_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """The order that the structure tells is built, and no other."""
    built = []
    graph = scene_graph(chain(60), SCENE)
    assert is_large(graph)
    whole = elimination_choice.Elimination.solve

    def noted(system: object, strategy: str) -> object:
        if not isinstance(system.graph, Structure):  # type: ignore[attr-defined]
            built.append(strategy)
        return whole(system, strategy)  # type: ignore[arg-type]

    monkeypatch.setattr(elimination_choice.Elimination, "solve", noted)
    _, strategy = accelerations(graph, tuple(range(graph.m)), spread=1.0)
    assert built == [strategy] == ["mixed"]


def test_structure_counts_operations_up_to_its_limit() -> None:
    """Numbers and parameters fold; products count one, quotients five; the limit ends the count."""
    structure = Structure(limit=6)
    moving, parameter, two = structure.moving, structure.parameter, structure.constant(2.0)
    assert structure.mul(parameter, structure.add(parameter, two)) == parameter
    assert structure.mul(structure.zero, moving) == structure.zero
    assert structure.floats[structure.mul(two, two)] == 4.0
    assert structure.cost == 0
    assert structure.sub(moving, structure.mul(moving, structure.one)) == moving
    assert structure.div(parameter, moving) == moving
    assert structure.cost == 6
    with pytest.raises(CostExceededError):
        structure.add(moving, two)

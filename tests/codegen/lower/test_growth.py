"""Counts of the work of lowering grow no faster than the machine."""

import pytest

from benchmarks.chain import SCENE, chain
from codegen.derive.equations import derive
from codegen.driver import valid_scenes
from codegen.lower.kernels.accelerations import dynamics_kernel
from codegen.lower.linear.pivot_order import PivotOrder
from codegen.lower.scene_graph import SceneGraph


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
        model, offers[0] = chain(links), 0
        (scene,) = valid_scenes(model, SCENE)
        graph = SceneGraph(derive(model, scene))
        equations = len(graph.graph.values)
        dynamics_kernel(graph, "mixed", tuple(range(graph.m)))
        counts.append((equations, len(graph.graph.values) - equations, offers[0]))
    small, large = counts
    assert all(0 < many <= 4.4 * few for few, many in zip(small, large, strict=True)), counts

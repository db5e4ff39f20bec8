"""Dependent rows of large machines: those of dense orthogonalisation, by sparse factors."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from codegen.check import kinematics
from codegen.check.kinematics import TOLERANCE, Findings, examine
from codegen.derive.equations import derive
from codegen.lower import poses_near_start
from codegen.lower.interpreter import LevelEvaluation
from codegen.lower.lowered_scene import Lowered, lower
from codegen.lower.poses_near_start import Poses, dependent_rows, least_norm
from codegen.model import Model
from codegen.reading.scene_selection import valid_scenes
from models.hard.n_four_bar import n_four_bar
from models.hard.parallel_linkage import parallel_linkage
from tests.codegen.lower.test_poses_near_start import chain


def findings(model: Model, scene: str | None) -> tuple[Findings, Lowered]:
    (chosen, *_) = valid_scenes(model, scene)
    equations = derive(model, chosen)
    lowered = lower(equations)
    return examine(model, equations, lowered), lowered


@pytest.mark.parametrize("seed", range(4))
def test_dependent_rows_are_those_of_orthogonalisation(seed: int) -> None:
    random = np.random.default_rng(seed)
    dense = random.standard_normal((40, 60)) * (random.random((40, 60)) < 0.15)
    for row in (7, 20, 21, 33, 34, 39)[: seed + 3]:
        dense[row] = random.standard_normal(3) @ dense[[2, 5, 6]]
    dense[25] = dense[26]
    expected = kinematics._dependent_rows(dense)
    assert len(expected) == seed + 4
    assert dependent_rows(csr_array(dense), TOLERANCE) == expected


def test_least_norms_are_those_of_dense_least_squares() -> None:
    random = np.random.default_rng(1)
    dense = random.standard_normal((30, 50)) * (random.random((30, 50)) < 0.3)
    dense[11] = 2.0 * dense[3] - dense[4]
    right = dense @ random.standard_normal(50)
    expected = np.linalg.lstsq(dense, right, rcond=1e-10)[0]
    np.testing.assert_allclose(least_norm(csr_array(dense), right), expected, atol=1e-10)


@pytest.mark.parametrize(
    ("model", "scene"),
    [(n_four_bar(6), "fall"), (parallel_linkage(4), "fall"), (chain(12), None)],
    ids=lambda value: getattr(value, "name", str(value)),
)
def test_sparse_and_dense_findings_are_the_same(
    model: Model, scene: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    dense, lowered = findings(model, scene)
    monkeypatch.setattr(poses_near_start, "SPARSE_FROM", 0)
    sparse, _ = findings(model, scene)
    assert Poses(lowered).is_sparse
    assert sparse == dense
    assert bool(sparse.notes) == (model.name.startswith("parallel"))


def test_levels_do_not_grow_and_compute_what_the_interpreter_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As many calls of NumPy for 40 loops as for 10; one Python call an operation would be four."""
    calls = []
    for loops in (10, 40):
        _, lowered = findings(n_four_bar(loops), "fall")
        levels = LevelEvaluation(lowered.program, lowered.kernels["jacobian"])
        assert levels.suits
        calls.append(levels.calls)
        poses = Poses(lowered)
        dense = poses.jacobian(poses.guess)
        with monkeypatch.context() as patch:
            patch.setattr(poses_near_start, "SPARSE_FROM", 0)
            sparse = Poses(lowered)
        np.testing.assert_array_equal(sparse.jacobian(poses.guess).toarray(), dense)
        assert sparse.size == poses.size
    assert calls[0] == calls[1]

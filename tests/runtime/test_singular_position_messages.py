"""Joints that stand in the way of a driver: in which order, and how many."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from runtime.continuation.singular_position_messages import describe, lock_up


def test_joints_are_ranked_by_all_their_rows() -> None:
    elements = ["guide", *"AABBCCDD", "drive"]
    part = np.array([0.4, *[0.35] * 2, *[0.3] * 2, *[0.2] * 2, *[0.1] * 2, 0.5])
    coordinate = SimpleNamespace(name="body.phi")
    description = SimpleNamespace(
        constraints=[SimpleNamespace(element=one) for one in elements], drivers=("drive",),
        coordinates=[coordinate], is_length=np.array([False]),
    )  # fmt: skip
    equations: Any = SimpleNamespace(description=description, m=10, n=1)
    at: Any = SimpleNamespace(
        equations=equations, rows=np.arange(10), left=part[:, None], null=np.ones((1, 1)), k=1,
        t=1.0, q=np.zeros(1), scale=np.ones(1), values=np.zeros(1), drift=lambda rate: 1.0,
    )  # fmt: skip
    found = describe(at, "lock-up", np.zeros(1), 1.0)
    assert found.joints == ("A", "B", "guide", "C", "D")
    assert "joints A, B, guide, C and 1 more stand in the way" in lock_up(equations, found)

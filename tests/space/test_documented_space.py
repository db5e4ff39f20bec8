"""The example of docs/how-to/space.md, run as it stands there, against a planar calculation."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose


@pytest.fixture(scope="module")
def shown(root: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Everything that the page's code defines."""
    pyplot = pytest.importorskip("matplotlib.pyplot")
    text = (root / "docs" / "how-to" / "space.md").read_text(encoding="utf-8")
    names: dict[str, Any] = {"__name__": "documented_space"}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("space"))
        for block in re.findall(r"```\{code-cell\} ipython3\n(.*?)```", text, re.DOTALL):
            exec(block, names)
    pyplot.close("all")
    return names


def test_the_slider_crank(shown: dict[str, Any]) -> None:
    r = shown["r"]
    y, z = r.point("pin")[:, 1:].T
    assert_allclose(r.q("slider.x"), np.sqrt(0.09 - y**2 - z**2), rtol=0.0, atol=1e-9)
    # no force does work: gravity acts on bodies that keep their height
    kinetic = 0.5e-4 * r.v("crank.omega_x") ** 2 + 1.0 * r.v("slider.vx") ** 2
    assert_allclose(kinetic, kinetic[0], rtol=1e-6)

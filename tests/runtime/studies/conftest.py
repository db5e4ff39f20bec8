"""A mass on a spring, and work-precision studies of it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from runtime import accuracy
from runtime.studies.diagram import WorkPrecision

TEXT = """
from codegen import Model

model = Model("rig", gravity=(0, -9.81))
body = model.body("body", mass=2.0, inertia=0.1)
guide = model.translational("guide", model.ground, body, axis=(1, 0))
model.spring("spring", model.ground.at(-1, 0), body, 50.0, free_length=1.0)
model.friction("rub", guide, 0.05, creep=1e-3, fidelity="regularised")
model.driver("drive", body.x, 0.5)
start = {body.x: 0.5, body.vx: 0.0}
model.scene("swing", ["spring"], start=start)
model.scene("rubbing", ["gravity", "spring", "rub"], start=start)
model.scene("sticking", ["gravity", "spring", "rub"], start=start, fidelity={"rub": "sticking"})
model.scene("driven", ["spring"], ["drive"])
model.scene("drawn", drivers=["drive"], analysis="kinematics")
"""
ABOUT: dict[str, Any] = {"t_end": 2.0, "rtols": (1e-3, 1e-6, 1e-9), "quick": True, "points": 40}


@pytest.fixture(scope="session")
def folder(request: pytest.FixtureRequest) -> Path:
    """A folder whose compiled scenes outlive a run, with the model in it."""
    made: Path = request.config.cache.mkdir("accuracy")
    (made / "models").mkdir(exist_ok=True)
    (made / "models" / "rig.py").write_text(TEXT, encoding="utf-8")
    return made


@pytest.fixture(scope="session")
def rig(folder: Path) -> str:
    """A mass on a spring: x = cos(5 t) / 2."""
    return str(folder / "models" / "rig.py")


@pytest.fixture(scope="session")
def study(rig: str, folder: Path) -> Callable[..., WorkPrecision]:
    """A small study of a scene: explicit methods in all coordinates."""
    few = {"methods": ("dop853", "dopri5"), "formulations": ("cartesian",), "modelling": False}
    return lambda scene="swing", **more: accuracy(
        rig, scene, folder=folder, **{**ABOUT, **few, **more}
    )


@pytest.fixture(scope="session")
def swing(rig: str, folder: Path) -> WorkPrecision:
    """Every setting at three tolerances."""
    return accuracy(rig, "swing", folder=folder, **ABOUT)

"""Machines of the library on which accuracy targets are tested."""

from pathlib import Path

import pytest

from codegen.generated_files.generated_file import write_if_changed
from runtime import load
from runtime.machine_facade import Machine


def load_library_model(root: Path, workshop: Path, name: str, scene: str) -> Machine:
    """A machine of the library, built in the tests' own folder."""
    path = workshop / "models" / f"library_{Path(name).name}.py"
    write_if_changed(path, (root / "models" / f"{name}.py").read_text())
    return load(path, scene, folder=workshop)


@pytest.fixture(scope="module")
def thrown(root: Path, workshop: Path) -> Machine:
    """A double pendulum whose motion is chaotic."""
    return load_library_model(root, workshop, "hard/double_pendulum", "thrown")


@pytest.fixture(scope="module")
def pendulum_point(root: Path, workshop: Path) -> Machine:
    """A point mass on a string."""
    return load_library_model(root, workshop, "hard/pendulum", "point")

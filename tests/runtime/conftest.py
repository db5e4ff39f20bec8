"""Hand-written machines for the runtime's tests, compiled once and kept in pytest's cache."""

import importlib.util
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from codegen.generated_files.generated_file import write_if_changed
from runtime import load
from runtime.integrate import checkpoints
from runtime.machine_facade import Machine
from runtime.mechanism.mechanism import Origin


def _mechanisms() -> ModuleType:
    name = "linkwright_test_mechanisms"
    if name not in sys.modules:
        path = Path(__file__).with_name("mechanisms.py")
        spec = importlib.util.spec_from_file_location(name, path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
    return sys.modules[name]


@pytest.fixture(scope="session")
def mechanisms() -> ModuleType:
    """The builder of hand-written generated modules."""
    return _mechanisms()


@pytest.fixture(scope="session")
def workshop(request: pytest.FixtureRequest) -> Path:
    """A folder of models and their generated modules; numba's cache beside them outlives a run."""
    folder: Path = request.config.cache.mkdir("runtime-mechanisms")
    return folder


@pytest.fixture(scope="session")
def library(root: Path, workshop: Path) -> Callable[[str, str], Machine]:
    """Load a machine of the library: library("hard/n_four_bar", "fall").

    Its equations are compiled where all load them; reduced equations, which the library does not
    keep, are built beside a copy of its model in the tests' own folder.
    """

    def loaded(name: str, scene: str) -> Machine:
        machine = load(root / "models" / f"{name}.py", scene)
        copied = workshop / "library"
        model = copied / "models" / f"{name}.py"
        write_if_changed(model, (root / "models" / f"{name}.py").read_text(encoding="utf-8"))
        path = copied / "generated" / machine.path.name
        origin = Origin(model, scene, path, machine.path.read_text(encoding="utf-8"))
        return Machine(replace(machine.mechanism, origin=origin))

    return loaded


@pytest.fixture(scope="session")
def make(mechanisms: ModuleType, workshop: Path) -> Callable[..., Machine]:
    """Write, compile and load a machine: make("slider_crank", "free", gas=True)."""

    def made(kind: str, scene: str, **options: Any) -> Machine:
        mechanism = getattr(mechanisms, kind)(scene, **options)
        return load(mechanism.write(workshop), scene, folder=workshop)

    return made


@pytest.fixture
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checkpoints between all chunks of steps, so that short runs have some too."""
    monkeypatch.setattr(checkpoints, "_SPACING", 0.0)


@pytest.fixture(scope="session")
def pendulum(make: Callable[..., Machine]) -> Machine:
    """A bar hanging from one end."""
    return make("pendulum", "swing")


@pytest.fixture(scope="session")
def free(make: Callable[..., Machine]) -> Machine:
    """The slider-crank under gravity, nothing driven."""
    return make("slider_crank", "free")


@pytest.fixture(scope="session")
def driven(make: Callable[..., Machine]) -> Machine:
    """The slider-crank with its crank driven."""
    return make("slider_crank", "driven", driven=True)


@pytest.fixture(scope="session")
def gas(make: Callable[..., Machine]) -> Machine:
    """The slider-crank with a force that acts while the slider moves outwards."""
    return make("slider_crank", "gas", gas=True)

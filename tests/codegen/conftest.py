"""Scenes that many tests look at, made once."""

from pathlib import Path

import pytest

from codegen import build
from codegen.files.generated_modules import import_generated
from codegen.reading.model_file import read_model
from codegen.reading.scene_selection import valid_scenes
from tests.codegen.machines import ODD
from tests.codegen.workbench import Interpreted

Scenes = dict[str, Interpreted]


@pytest.fixture(scope="session")
def slider_crank(root: Path) -> Scenes:
    """All scenes of the library's slider-crank."""
    model = read_model(root / "models" / "slider_crank.py").model
    return {scene.name: Interpreted(model, scene.name) for scene in valid_scenes(model, None)}


@pytest.fixture(scope="session")
def scenes(slider_crank: Scenes) -> Scenes:
    """The slider-crank's scenes, and those of the unusual machines."""
    found = dict(slider_crank)
    for declare in ODD:
        model = declare()
        for scene in valid_scenes(model, None):
            found[f"{model.name}.{scene.name}"] = Interpreted(model, scene.name)
    return found


@pytest.fixture(scope="session")
def texts(scenes: Scenes) -> dict[str, str]:
    """The generated text of each scene."""
    return {name: machine.text() for name, machine in scenes.items()}


@pytest.fixture(scope="session")
def compiled(root: Path, request: pytest.FixtureRequest) -> dict[str, object]:
    """Modules of all scenes of the slider-crank and of an odd machine, in machine code.

    The library's are compiled where they lie, as whoever loads them does; the odd one stays in
    pytest's cache.
    """
    library = build(root / "models" / "slider_crank.py", check=True)
    assert not library.stale, "run: linkwright build slider_crank"
    folder: Path = request.config.cache.mkdir("codegen-compiled")
    odd = folder / "names.py"
    odd.write_text(
        "from tests.codegen.machines import names_like_arguments as declare\n\nmodel = declare()\n"
    )
    return {
        (s.scene if s.model == "slider_crank" else f"{s.model}.{s.scene}"): import_generated(s.path)
        for report in (library, build(odd, out=folder / "generated"))
        for s in report.scenes
    }

"""The one door: found, checked, rebuilt, and quick; the machine that was asked for."""

import json
import subprocess
import sys
from collections import namedtuple
from pathlib import Path
from types import ModuleType

import pytest

import codegen
from codegen import Model
from codegen.errors import GeneratedFileError, ModelFileError
from codegen.files.build_records import generator_state
from codegen.files.generated_modules import import_generated
from codegen.files.library_folders import find_model_file
from runtime import load
from runtime.machine_facade import Machine

Report = namedtuple("Report", "paths")


@pytest.fixture
def place(tmp_path: Path, mechanisms: ModuleType) -> Path:
    """A folder with one model and its fresh module, whose kernels are never compiled."""
    mechanisms.pendulum("swing").write(tmp_path)
    return tmp_path


def _module(folder: Path) -> Path:
    return folder / "generated" / "rod_pendulum__swing.py"


def test_first_scene_is_read_from_the_model_file(pendulum: Machine, workshop: Path) -> None:
    machine = load("rod_pendulum", folder=workshop)
    assert (machine.model, machine.scene) == ("rod_pendulum", "swing")
    assert machine.kernels.accelerations is pendulum.kernels.accelerations


def test_unknown_model_names_the_nearest(place: Path) -> None:
    with pytest.raises(ModelFileError, match=r"no model 'rod_pendulm'.*Models there: rod_pendulum"):
        load("rod_pendulm", folder=place)


def test_a_name_without_its_suffix_is_answered_with_the_file_beside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "lift.py").write_text("model = Model('lift')")
    (tmp_path / "notes.py").write_text("print('no machine')")
    monkeypatch.chdir(tmp_path)
    for read in (load, find_model_file):
        with pytest.raises(ModelFileError, match=r"did you mean lift\.py\?$"):
            read("lift")
    with pytest.raises(ModelFileError, match=r"Models there: lift\.$"):
        load("./notess.py")


def test_model_that_does_not_parse_names_the_line(place: Path) -> None:
    (place / "models" / "broken.py").write_text("model = Model(\n")
    with pytest.raises(ModelFileError, match=r"broken\.py, line 1"):
        load("broken", folder=place)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("2.0, 'kg'", "3.0, 'kg'", "edited by hand.*linkwright build .*--scene swing"),
        ("# content-sha256", "# content", "no content-sha256 line"),
    ],
)
def test_module_that_is_not_as_it_was_written_is_refused_with_the_way_out(
    place: Path, old: str, new: str, message: str
) -> None:
    path = _module(place)
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(GeneratedFileError, match=message):
        load("rod_pendulum", folder=place)


@pytest.mark.parametrize("change", ["model", "generator", "missing", "source gone", "text"])
def test_stale_or_missing_module_is_rebuilt(
    place: Path, mechanisms: ModuleType, monkeypatch: pytest.MonkeyPatch, change: str
) -> None:
    model = place / "models" / "rod_pendulum.py"
    path = _module(place)
    if change == "model":
        model.write_text(model.read_text() + "# heavier\n")
    elif change == "missing":
        path.unlink()
    else:
        record = path.parent / "__pycache__" / f"{path.stem}.build.json"
        old, new = {
            "generator": (generator_state(), "of other sources"),
            "source gone": ("models/rod_pendulum.py", "models/rod_pendulum_.py"),
            "text": ('["', '["f'),
        }[change]
        assert old in record.read_text()
        record.write_text(record.read_text().replace(old, new, 1))
    asked = []

    def build(
        model_path: Path, scene: str | None = None, out: Path | None = None, **_: bool
    ) -> Report:
        asked.append((Path(model_path), scene, out))
        raise GeneratedFileError("the generator was called")

    monkeypatch.setattr(codegen, "build", build, raising=False)
    with pytest.raises(GeneratedFileError, match="the generator was called"):
        load("rod_pendulum", "swing", folder=place)
    assert asked == [(model, "swing", place / "generated")]


def test_module_that_does_not_load_says_why(place: Path) -> None:
    path = _module(place)
    path.write_text(path.read_text().replace("import numba\n", "import no_such_library\n"))
    with pytest.raises(GeneratedFileError, match="does not load: ModuleNotFoundError"):
        import_generated(path)


def test_new_process_takes_kernels_from_the_cache(pendulum: Machine, workshop: Path) -> None:
    script = (
        "import json, sys; from runtime import load; from runtime.core.jit import prepare\n"
        f"machine = load('rod_pendulum', folder={str(workshop)!r})\n"
        "kernels = machine.kernels\n"
        "names = ('accelerations', 'correction', 'switching')\n"
        "for name in names: prepare(getattr(kernels, name))\n"
        "stats = [getattr(kernels, name).stats for name in names]\n"
        "hits = [sum(s.cache_hits.values()) for s in stats]\n"
        "misses = [sum(s.cache_misses.values()) for s in stats]\n"
        "machine.assemble()\n"
        "print(json.dumps([hits, misses, sorted(sys.modules)]))\n"
    )
    hits, misses, modules = json.loads(_python(script))
    assert hits == [1, 1, 1]
    assert misses == [0, 0, 0]
    assert "sympy" not in modules
    assert "pint" not in modules
    assert "xarray" not in modules
    assert "matplotlib" not in modules
    assert "scipy.optimize" not in modules


def test_models_of_the_library_may_be_a_link(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library = tmp_path / "library"
    (library / "generated").mkdir(parents=True)
    (tmp_path / "elsewhere").mkdir()
    (library / "models").symlink_to(tmp_path / "elsewhere")
    (library / "models" / "stone.py").touch()
    loading = sys.modules["runtime.machine_loading"]
    monkeypatch.setattr(loading, "_LIBRARY", library)
    found = tmp_path / "elsewhere" / "stone.py", library / "generated"
    assert loading._locate("stone", tmp_path / "work") == found


def test_user_model_builds_into_the_folder_one_works_in(tmp_path: Path) -> None:
    path = tmp_path / "models" / "stone.py"
    path.parent.mkdir()
    path.write_text(
        "from codegen import Model\n"
        "model = Model('stone')\n"
        "stone = model.body('stone', mass=model.parameter('m', 2.0, unit='kg'), inertia=1.0)\n"
        "model.force('wind', on=stone, fx=4.0)\n"
        "model.scene('windy', effects=['wind'])\n"
    )
    machine = load("stone", folder=tmp_path)
    assert machine.path == tmp_path / "generated" / "stone__windy.py"
    assert load("stone", folder=tmp_path).kernels.accelerations is machine.kernels.accelerations
    path.write_text(path.read_text().replace("fx=4.0", "fx=8.0"))
    fresh = load("stone", folder=tmp_path)
    assert fresh.simulate(1.0, [0.0, 1.0]).q("stone.x")[1] == pytest.approx(2.0, abs=1e-12)


def test_importing_the_runtime_loads_nothing_heavy() -> None:
    modules = json.loads(
        _python("import runtime, sys, json; print(json.dumps(sorted(sys.modules)))")
    )
    assert not {"numba", "numpy", "sympy", "xarray", "rich", "typer"} & set(modules)


def _python(script: str) -> str:
    root = Path(codegen.__file__).resolve().parent.parent
    return subprocess.run(
        [sys.executable, "-c", script], cwd=root, capture_output=True, text=True, check=True
    ).stdout


TEXT = """\
from codegen import Model

model = Model("mm", gravity=(0, -{g}))
model.body("body", 1.0, 1.0)
model.scene("fall", ["gravity"])
"""


def fall(machine: object) -> float:
    return float(machine.simulate(1.0, [0.0, 1.0]).a("body.y")[-1])  # type: ignore[attr-defined]


def test_models_of_one_name_in_several_folders(tmp_path: Path) -> None:
    for folder, g in ((".", 9.0), ("one", 21.0), ("two", 22.0)):
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / "mm.py").write_text(TEXT.format(g=g))
    for name, g in (("mm.py", 9.0), ("one/mm.py", 21.0), ("two/mm.py", 22.0), ("mm.py", 9.0)):
        assert fall(load(name, "fall", folder=tmp_path)) == -g


def test_a_file_and_a_model_in_memory_of_one_name(tmp_path: Path) -> None:
    model = Model("mm", gravity=(0, -1.0))
    model.body("body", 1.0, 1.0)
    model.scene("fall", ["gravity"])
    (tmp_path / "mm.py").write_text(TEXT.format(g=9.81))
    machine = load(model, "fall", folder=tmp_path)
    assert machine.path.parent == tmp_path / "generated"
    assert fall(machine) == -1.0
    assert fall(load("mm.py", "fall", folder=tmp_path)) == -9.81
    assert fall(load(model, "fall", folder=tmp_path)) == -1.0

"""A generated module is built again where generator, model, or what this asks for has changed."""

import os
import sqlite3
import sys
import warnings
from pathlib import Path
from types import ModuleType

import pytest

from codegen import build
from codegen.errors import SupersededError
from codegen.files import build_records
from codegen.files.build_records import unchanged
from runtime import load
from runtime.machine_facade import Machine
from runtime.machine_loading import _fresh_module
from runtime.mechanism.mechanism import read_mechanism

PENDULUM = """
from codegen import Model
model = Model("pendulum", gravity=(0, -9.81))
bob = model.body("bob", mass=2.0, inertia=0.1)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-L, 0))
model.scene("swing", ["gravity"])
"""


def _data(value: float) -> None:
    """The number in all the places from which models read it."""
    for name in ("data.json", "data.txt", "late.txt"):
        Path(name).write_text(str(value))
    Path("late_of_it.py").write_text(f"L = {value}\n")
    Path("numbers_of_it.py").write_text(f"L = {value}\n")
    os.environ["LENGTH_OF_IT"] = str(value)
    (Path("list") / f"{value}.txt").touch()
    with sqlite3.connect("data.db") as base:
        base.executescript(f"drop table if exists t; create table t as select {value} as x")
    base.close()


HELPER = """
import contextlib, sqlite3

def stored(path):
    with contextlib.closing(sqlite3.connect(path)) as base:
        return base.execute("select x from t").fetchone()[0]
"""

THREAD = """
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
with ThreadPoolExecutor() as pool:
    L = float(*pool.map(Path.read_text, [Path("data.txt")]))
"""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LENGTH_OF_IT", "1.0")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "numbers_of_it", raising=False)
    monkeypatch.setitem(sys.modules, "memory_of_it", ModuleType("memory_of_it"))
    vars(sys.modules["memory_of_it"])["L"] = 1.0
    (tmp_path / "list").mkdir()
    (tmp_path / "helper_of_it.py").write_text(HELPER)
    _data(1.0)
    (tmp_path / "late.txt").unlink()
    (tmp_path / "late_of_it.py").unlink()
    return tmp_path


def _text(place: Path, scene: str | None = "swing") -> str:
    path, text = _fresh_module(place / "pendulum.py", place / "generated", scene)
    assert text == path.read_text()
    return text


@pytest.mark.parametrize(
    ("ahead", "is_watched"),
    [
        ("import json\nwith open('data.json') as file: L = json.load(file)", True),
        ("import numpy\nL = float(numpy.loadtxt('data.txt'))", True),
        ("import importlib\nL = importlib.import_module('numbers_of_it').L", True),
        ("from numbers_of_it import L", True),
        ("import runpy\nL = runpy.run_path('numbers_of_it.py')['L']", True),
        ("import os\nL = float(os.environ['LENGTH_OF_IT'])", True),
        ("import os\nL = float(dict(os.environ).get('LENGTH_OF_IT', 1.0))", True),
        ("from pathlib import Path\nL = min(float(x.stem) for x in Path('list').iterdir())", True),
        ("try: L = float(open('late.txt').read())\nexcept OSError: L = 1.0", True),
        ("import helper_of_it\nL = helper_of_it.stored('data.db')", True),
        (THREAD, True),
        ("try: from late_of_it import L\nexcept ImportError: L = 1.0", True),
        ("import sys\nL = 1.0 + 0.0 * len(sys.argv)", False),
        ("import time\nL = 1.0 + 0.0 * int(time.strftime('%S'))", False),
        ("import sys\nL = float(open('data.txt').read())\nif __name__ == '0': sys.argv", True),
        ("import memory_of_it\nL = 1.0 + 0.0 * memory_of_it.L", False),
        ("import os\nL = 0.5 if os.path.exists('late.txt') else 1.0", False),
        ("import subprocess\nL = float(subprocess.check_output(['cat', 'data.txt']))", False),
        ("import numpy\nL = 1.0 + 0.0 * numpy.random.default_rng(3).random()", True),
        ("import numpy\nL = 1.0 + 0.0 * numpy.random.normal()", False),
        ("import numpy\nL = 1.0 + 0.0 * numpy.random.default_rng().normal()", False),
        ("import random as rnd\nL = 1.0 + 0.0 * rnd.gauss()", False),
        ("import datetime\nL = 1.0 + 0.0 * datetime.datetime.now().year", False),
        ("from time import time as clock\nL = 1.0 + 0.0 * clock()", False),
        ("import os\nL = float(os.environb[b'LENGTH_OF_IT'])", True),
    ],
)
@pytest.mark.filterwarnings("ignore:unclosed file:ResourceWarning")
def test_all_that_a_model_asks_for_counts(place: Path, ahead: str, is_watched: bool) -> None:
    (place / "pendulum.py").write_text(f"{ahead}\n{PENDULUM}")
    sys.modules.pop("numbers_of_it", None)
    __import__("numbers_of_it")  # as a program does, which later edits the file
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", UserWarning)
        first = _text(place)
    record = unchanged(place / "generated" / "pendulum__swing.py", first, place / "pendulum.py")
    assert record is not None
    assert bool(record.unwatched) is not is_watched
    places = [row.filename for row in said if "read anew each time" in str(row.message)]
    assert places == [] if is_watched else __file__ in places
    assert sys.modules["numbers_of_it"].L == 1.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        assert _text(place) == first
        _data(0.5)
        constant = "0.0 *" in ahead
        assert (_text(place) == first) is constant


def test_without_a_change_nothing_is_built_and_other_sources_build_again(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ahead = (
        f"import sqlite3\nsqlite3.connect(':memory:').close()\nopen({str(place)!r} + '/log', 'w')"
    )
    (place / "pendulum.py").write_text(f"{ahead}.close()\nL = 1.0\n{PENDULUM}")
    first, built = _text(place, None), []
    (place / "log").write_text("another program")
    module = place / "generated" / "pendulum__swing.py"
    date = module.stat().st_mtime_ns

    def noted(*given: object, **options: object) -> object:
        built.append(given)
        return build(*given, **options)  # type: ignore[arg-type]

    monkeypatch.setattr("codegen.build", noted, raising=False)
    monkeypatch.chdir("/")  # the file asks for nothing relative to it
    assert (_text(place), _text(place, None), built) == (first, first, [])
    monkeypatch.setattr(build_records, "generator_state", lambda: "another generator")
    monkeypatch.setattr("codegen.generated_files.provenance.generator_state", lambda: "another")
    _text(place)
    assert len(built) == 1
    assert module.stat().st_mtime_ns == date  # the record alone was written


@pytest.mark.parametrize("declared", ["def make():\n{}\n    return model\nmodel = make()\n", "{}"])
def test_a_build_keeps_its_choice_of_loops(place: Path, declared: str) -> None:
    text = PENDULUM.replace("\n", "\n    ") if "def" in declared else PENDULUM
    model, module = place / "pendulum.py", place / "generated" / "pendulum__swing.py"
    model.write_text("L = 1.0\n" + declared.format(text))
    build(model, unroll="never", compile=False)
    texts = {module.read_text() for scene in ("swing", None) if _text(place, scene)}
    assert len(texts) == 1
    assert "--unroll never" in texts.pop()
    model.write_text(model.read_text() + "# edited\n")
    _text(place, None)
    assert "--unroll never" in module.read_text()


@pytest.mark.parametrize("changed", ["model", "data"])
def test_a_run_does_not_go_on_in_a_scene_of_another_model(place: Path, changed: str) -> None:
    released = 'model.release(model.joints["hinge"], when=bob.phi < -0.1)\nmodel.scene('
    text = PENDULUM.replace("model.scene(", released)
    ahead = "with open('data.txt') as file: L = float(file.read())\n"
    (place / "pendulum.py").write_text(ahead + text)
    path, generated = _fresh_module(place / "pendulum.py", place / "generated", "swing")
    machine = Machine(read_mechanism(path, generated, place / "pendulum.py", "swing"))
    if changed == "model":
        (place / "pendulum.py").write_text((place / "pendulum.py").read_text() + "# edited\n")
    else:
        _data(0.5)
    with pytest.raises(SupersededError, match=r"Load the machine again"):
        machine.simulate(0.5, 3)


@pytest.mark.filterwarnings("error")
def test_a_model_of_chance_is_told_how_it_can_be_built_further(
    place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    released = 'model.release(model.joints["hinge"], when=bob.phi < -0.1)\nmodel.scene('
    text = PENDULUM.replace("model.scene(", released)
    (place / "pendulum.py").write_text(f"import random\nL = 1.0 + random.random()\n{text}")
    machine = load(place / "pendulum.py", "swing")
    assert "random, pendulum.py, line 1" in capsys.readouterr().err
    for needed in (lambda: machine.simulate(0.5, 3), lambda: machine.mechanism.reduced):
        with pytest.raises(SupersededError, match=r"differ at each reading \(random.*a\s+seed"):
            needed()

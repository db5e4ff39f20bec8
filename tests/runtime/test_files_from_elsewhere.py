"""Result files execute nothing, and come back in any folder by a machine given or loaded."""

import io
import json
import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from codegen import Model
from codegen.errors import InputError
from runtime import load, load_result
from runtime.integrate.problem import Discrete
from runtime.machine_facade import Machine
from runtime.results import export, zarr_store
from runtime.results.result import Result
from runtime.results.saved_result import pack, saved_fields

_MODEL = """
import os
from pathlib import Path
Path({mark!r}).write_text("executed")
from linkwright import Model
model = Model("bob_elsewhere", gravity=(0, -9.81))
bob = model.body("bob", mass=2.0, inertia=0.5)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
model.torque("stop", on=bob, value=-90.0 * bob.phi, when=bob.phi < 0)
model.scene("swing", effects=["gravity", "stop"], start={{bob.phi: 0.4, bob.omega: 0.0}})
"""
NOT_OPENED = ({"zarr_format": 2}, {"codecs": [{"name": "pickle"}]}, {"data_type": "object"},
              {"storage_transformers": [{"name": "run"}]})  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("elsewhere")
    (place / "bob.py").write_text(_MODEL.format(mark=str(place / "mark")))
    return place


@pytest.fixture(scope="module")
def machine(folder: Path) -> Machine:
    return load(folder / "bob.py", folder=folder)


@pytest.fixture(scope="module")
def result(machine: Machine) -> Result:
    return machine.simulate(0.8, 41)


Sent = Callable[..., Path]


@pytest.fixture
def sent(result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Sent:
    """Save the result, or another one, with fields that somebody has changed, or other bytes."""

    def save(
        ending: str, change: Callable[[dict[str, Any]], None] = lambda _: None,
        content: bytes | None = None, of: Result = result,
    ) -> Path:  # fmt: skip
        def packed(of: Result) -> bytes:
            fields = saved_fields(of)
            change(fields)
            return pack(fields) if content is None else content

        with monkeypatch.context() as other:
            for module in (export, zarr_store):
                other.setattr(module, "saved_result", packed)
            return of.save(tmp_path / f"run{ending}")

    return save


@pytest.mark.parametrize("ending", [".nc", ".zarr"])
def test_the_model_that_a_file_names_is_not_executed(
    result: Result, folder: Path, tmp_path: Path, ending: str
) -> None:
    """Also where it is newer than its module, so that a load would execute it."""
    path = result.save(tmp_path / f"run{ending}")
    model = folder / "bob.py"
    model.write_text(f"{model.read_text()}# changed\n")
    (folder / "mark").unlink(missing_ok=True)
    program = """
import sys
from runtime import load_result
try:
    load_result(sys.argv[1])
except Exception as error:
    print(type(error).__name__, error)
"""
    run = [sys.executable, "-c", program, path]
    said = subprocess.run(run, capture_output=True, text=True, check=True).stdout
    assert "InputError" in said
    assert "bob.py, scene swing) and give it: load_result(path, machine=load(...))" in said
    assert not (folder / "mark").exists()


@pytest.mark.parametrize("given", [True, False])
def test_the_machine_is_the_one_that_is_given_or_loaded(
    result: Result, machine: Machine, folder: Path, tmp_path: Path, given: bool
) -> None:
    (folder / "mark").unlink(missing_ok=True)
    found = load_result(result.save(tmp_path / "run.nc"), machine if given else None)
    np.testing.assert_array_equal(found.q("bob.phi"), result.q("bob.phi"))
    np.testing.assert_array_equal(found.at(0.61).v("bob.omega"), result.at(0.61).v("bob.omega"))
    assert not (folder / "mark").exists()


def test_no_loaded_machine_is_taken_where_no_text_of_its_model_is_told(
    sent: Sent, machine: Machine, result: Result
) -> None:
    """So it is with an equilibrium; a model that was edited since would compute other forces."""

    def still(fields: dict[str, Any]) -> None:
        fields["motion"] = None

    path = sent(".nc", still)
    with pytest.raises(InputError, match=r"does not say from which text .* bob_elsewhere/swing"):
        load_result(path)
    np.testing.assert_array_equal(load_result(path, machine).samples.q, result.samples.q)


def test_no_checkpoint_is_written_or_read(sent: Sent, machine: Machine, result: Result) -> None:
    """Older files have some: they are left out, and all else is read."""

    class Checkpoint(NamedTuple):
        t: float
        state: Any

    def poison(fields: dict[str, Any]) -> None:
        assert "checkpoints" not in fields["motion"]
        fields["motion"]["checkpoints"] = [Checkpoint(0.1, np.array([1, 2, 3]))]

    found = load_result(sent(".nc", poison), machine)
    assert found._motion.checkpoints.rows == []  # type: ignore[union-attr]
    np.testing.assert_array_equal(found.at(0.61).v("bob.omega"), result.at(0.61).v("bob.omega"))
    np.testing.assert_array_equal(found.resume(1.0, 5).samples.q, result.resume(1.0, 5).samples.q)


@pytest.mark.parametrize(
    ("part", "name", "value"),
    [
        ("samples", "q", np.zeros((41, 1))),
        ("samples", "q", np.zeros((41, 3), np.complex128)),
        ("samples", "v", np.zeros((40, 3))),
        ("samples", "t", np.zeros((41, 2))),
        ("samples", "modes", np.full((41, 1), 7)),
        ("samples", "modes", np.zeros((41, 9), np.int64)),
        ("samples", "modes", np.zeros((41, 1))),
        ("motion", "q", np.zeros(2)),
        ("motion", "v", np.zeros(2)),
    ],
)
def test_arrays_of_other_shapes_are_refused(
    sent: Sent, machine: Machine, part: str, name: str, value: Any
) -> None:
    def poison(fields: dict[str, Any]) -> None:
        fields[part] = {**fields[part], name: value}

    with pytest.raises(InputError, match=rf"the array {name} of the file has the shape"):
        load_result(sent(".nc", poison), machine)


@pytest.fixture(scope="module")
def sampled(workshop: Path) -> Machine:
    model = Model("sampled_elsewhere")
    cart = model.particle("cart", 1.0)
    model.absolute("rail", cart, "y", 0.0)
    pull = model.sampled("pull", 0.1, -cart.x, unit="N", delay=0.15)
    model.force("actuator", cart, fx=pull)
    model.scene("run", ["actuator"], start={cart.x: 1.0, cart.vx: 0.0})
    return load(model, folder=workshop)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("ticks", np.zeros(8, np.int64), "the array ticks of the file has the shape"),
        ("ticks", np.array([1 << 40, 0]), "clocks that wait for what never comes"),
        ("waiting", np.zeros((1, 900)), "the array waiting of the file has the shape"),
        ("held", np.zeros(3), "the array held of the file has the shape"),
    ],
)
def test_clocks_of_other_shapes_are_refused(
    sent: Sent, sampled: Machine, field: str, value: Any, message: str
) -> None:
    run = sampled.simulate(0.33, 5)
    back = load_result(sent(".nc", of=run), sampled)
    assert (back.resume(0.5, 3).samples.q == run.resume(0.5, 3).samples.q).all()

    def poison(fields: dict[str, Any]) -> None:
        first, last = fields["motion"]["discrete"]
        assert isinstance(last, Discrete)
        fields["motion"]["discrete"] = first, last._replace(**{field: value})

    with pytest.raises(InputError, match=message):
        load_result(sent(".nc", poison, of=run), sampled)


class Bomb:
    """Its pickle leaves a mark."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.write_text, (self.mark, "executed")


@pytest.mark.parametrize("ending", [".nc", ".zarr"])
def test_pickles_in_arrays_are_not_read(
    sent: Sent, machine: Machine, tmp_path: Path, ending: str
) -> None:
    mark, file = tmp_path / "mark", io.BytesIO()
    text = np.frombuffer(b'{"array": 0}', np.uint8)
    np.savez(file, a0=np.array([Bomb(mark)], object), json=text)
    with pytest.raises(InputError, match="is damaged"):
        load_result(sent(ending, content=file.getvalue()), machine)
    assert not mark.exists()
    np.load(io.BytesIO(file.getvalue()), allow_pickle=True)["a0"]
    assert mark.exists()  # the bomb is one


@pytest.mark.parametrize(
    "content", ['{"kind": "system", "of": ["id"]}', '{"kind": "__import__", "of": ["os"]}', "[[["]
)
def test_kinds_that_are_none_of_a_result(sent: Sent, machine: Machine, content: str) -> None:
    file = io.BytesIO()
    np.savez(file, json=np.frombuffer(content.encode(), np.uint8))
    with pytest.raises(InputError, match="is damaged"):
        load_result(sent(".nc", content=file.getvalue()), machine)


def test_a_store_whose_filter_unpickles_is_not_opened(machine: Machine, tmp_path: Path) -> None:
    """Of Zarr's format 2, whose filter `pickle` executes what a chunk says where it is let."""
    store, mark = tmp_path / "run.zarr" / "linkwright", tmp_path / "mark"
    (store / "linkwright").mkdir(parents=True)
    about = {
        "zarr_format": 2, "shape": [1], "chunks": [1], "dtype": "|O", "fill_value": None,
        "order": "C", "compressor": None, "filters": [{"id": "vlen-utf8"}, {"id": "pickle"}],
    }  # fmt: skip
    (store / ".zgroup").write_text('{"zarr_format": 2}')
    (store.parent / ".zgroup").write_text('{"zarr_format": 2}')
    (store / "linkwright" / ".zarray").write_text(json.dumps(about))
    (store / "linkwright" / "0").write_bytes(pickle.dumps(Bomb(mark)))
    with pytest.raises(InputError, match="format 2, whose codecs may execute code"):
        load_result(store.parent, machine)
    assert not mark.exists()
    opened = "import sys, zarr; zarr.open_group(sys.argv[1], mode='r')['linkwright/linkwright'][:]"
    trusting = {**os.environ, "NUMCODECS_ALLOW_UNSAFE_PICKLE_DECODE": "1"}  # as older ones do
    command = [sys.executable, "-c", opened, store.parent]
    subprocess.run(command, check=False, capture_output=True, env=trusting)
    assert mark.exists()  # the bomb is one


@pytest.mark.parametrize("change", NOT_OPENED)
@pytest.mark.parametrize("consolidated", [False, True])
def test_a_store_that_needs_more_than_numbers_is_not_opened(
    result: Result, machine: Machine, tmp_path: Path, change: dict[str, Any], consolidated: bool
) -> None:
    path = result.save(tmp_path / "run.zarr")
    place = path / "q" / "zarr.json"
    about = json.loads(place.read_text()) | change
    if consolidated:
        place = path / "zarr.json"
        about = json.loads(place.read_text()) | {
            "consolidated_metadata": {"metadata": {"q": about}}
        }
    place.write_text(json.dumps(about))
    with pytest.raises(InputError, match="It is not opened"):
        load_result(path, machine)


@pytest.mark.parametrize("text", ["{", "[]", '{"zarr_format": 3}', "[" * 100_000])
def test_metadata_that_are_none(
    result: Result, machine: Machine, tmp_path: Path, text: str
) -> None:
    path = result.save(tmp_path / "run.zarr")
    (path / "q" / "zarr.json").write_text(text)
    with pytest.raises(InputError, match=r"q/zarr\.json cannot be read"):
        load_result(path, machine)


def test_texts_of_a_file_are_no_markup_on_a_page(
    sent: Sent, machine: Machine, tmp_path: Path
) -> None:
    markup = "</script><script>alert(1)</script><img src=x onerror=alert(1)>"

    def poison(fields: dict[str, Any]) -> None:
        fields["message"] = markup
        fields["not_unique"] = [markup]
        fields["events"]["names"] = [markup for _ in fields["events"]["names"]]
        fields["events"]["words"] = [markup for _ in fields["events"]["words"]]

    found = load_result(sent(".nc", poison), machine)
    assert found.events
    page = found.save(tmp_path / "page.html").read_text(encoding="utf-8")
    moving = found.animate().html
    for text in (page, moving, found._repr_html_()):
        assert "<script>alert" not in text
        assert "<img src=x" not in text


@pytest.mark.parametrize("own", [True, False])
def test_links_in_a_store_are_not_followed(
    result: Result, machine: Machine, tmp_path: Path, own: bool
) -> None:
    path = result.save(tmp_path / "run.zarr")
    parts = [part.name for part in path.iterdir() if part.is_dir()]
    (part, *_) = [name for name in parts if (name == "linkwright") is own]
    (path / part).rename(tmp_path / "elsewhere")
    (path / part).symlink_to("../elsewhere")
    with pytest.raises(InputError, match="is a link"):
        load_result(path, machine)


_FAR = """
from linkwright import Model
model = Model("{name}", gravity=(0, -9.81))
bob = model.body("bob", mass=2.0, inertia=0.5)
hinge = model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
model.torque("damper", on=bob, value=-{damping} * bob.omega)
model.release(hinge, when=bob.phi < -0.5)
model.scene("swing", effects=["gravity", "damper"], start={{bob.phi: 0.4, bob.omega: 0.0}})
"""


def _far_model(folder: Path, name: str, damping: float = 0.3) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.py").write_text(_FAR.format(name=name, damping=damping))
    return folder / f"{name}.py"


def test_a_result_comes_back_in_another_folder_and_with_a_machine_loaded_from_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _far_model(tmp_path / "one", "far_bob")
    (tmp_path / "two").mkdir()
    monkeypatch.chdir(tmp_path / "one")
    result = load("far_bob.py").simulate(0.6)
    assert len(result.reconnections) == 1
    result.save("far.nc")
    monkeypatch.chdir(tmp_path / "two")
    found = load_result("../one/far.nc")
    assert found.v("bob.omega").tolist() == result.v("bob.omega").tolist()
    assert found.at(0.31).q("bob.y") == result.at(0.31).q("bob.y")
    assert not (tmp_path / "two" / "generated").exists()  # the modules are those of the run
    monkeypatch.chdir(tmp_path)
    for generated in (None, "two/made"):  # built anew from another folder: the same equations
        machine = load("one/far_bob.py", generated=generated)
        again = load_result("one/far.nc", machine=machine)
        assert again.at(0.55).q("bob.x") == result.at(0.55).q("bob.x")


def test_a_result_of_another_model_is_refused_in_whatever_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _far_model(tmp_path / "one", "changed_bob")
    monkeypatch.chdir(tmp_path)
    before = load("one/changed_bob.py")
    place = before.simulate(0.1).save("far.nc")
    after = load(_far_model(tmp_path / "one", "changed_bob", damping=0.4))
    with pytest.raises(InputError, match=r"has changed since .*changed_bob__swing\.py computes"):
        load_result(place, after)
    assert load_result(place).q("bob.phi")[-1] != after.simulate(0.1).q("bob.phi")[-1]
    assert load_result(place, before).at(0.05).t == 0.05

"""Result files from elsewhere execute nothing: no model file, pickle, codec or checkpoint."""

import io
import json
import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen.errors import InputError
from runtime import load, load_result
from runtime.machine_facade import Machine
from runtime.results import export, zarr_store
from runtime.results.packed_values import pack
from runtime.results.result import Result
from runtime.results.saved_result import saved_fields

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


@pytest.fixture
def sent(
    result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, folder: Path
) -> Callable[..., Path]:
    """Save the result as another user, changed or not; the model would leave its mark."""

    def save(ending: str, change: Callable[[dict[str, Any]], None] | None = None) -> Path:
        def content(of: Result) -> bytes:
            fields = saved_fields(of)
            if change is not None:
                change(fields)
            return pack(fields)

        with monkeypatch.context() as other:
            other.setenv("XDG_DATA_HOME", str(tmp_path / "another user"))
            for module in (export, zarr_store):
                other.setattr(module, "saved_result", content)
            path = result.save(tmp_path / f"run{ending}")
        (folder / "mark").unlink(missing_ok=True)
        return path

    return save


@pytest.mark.parametrize("ending", [".nc", ".zarr"])
def test_the_model_of_a_file_from_elsewhere_is_not_executed(
    sent: Callable[..., Path], folder: Path, machine: Machine, result: Result, ending: str
) -> None:
    path = sent(ending)
    model = folder / "bob.py"
    text = model.read_text()
    model.write_text(f"{text}# newer than the module, so that a load executes it\n")
    with pytest.raises(InputError, match=r"not saved by you on this machine.*machine=load"):
        load_result(path)
    assert not (folder / "mark").exists()
    found = load_result(path, machine)
    np.testing.assert_array_equal(found.q("bob.phi"), result.q("bob.phi"))
    np.testing.assert_array_equal(found.at(0.61).v("bob.omega"), result.at(0.61).v("bob.omega"))
    assert not (folder / "mark").exists()
    model.write_text(text)


def test_own_files_name_their_model(result: Result, tmp_path: Path, folder: Path) -> None:
    fresh = load(folder / "bob.py", folder=folder).simulate(0.1)
    path = fresh.save(tmp_path / "own.nc")
    assert load_result(path).q("bob.phi").tolist() == fresh.q("bob.phi").tolist()


def test_checkpoints_from_elsewhere_reach_no_compiled_code(
    sent: Callable[..., Path], machine: Machine, result: Result
) -> None:
    def poison(fields: dict[str, Any]) -> None:
        fields["motion"]["checkpoints"] = ["an address"]

    found = load_result(sent(".nc", poison), machine)
    np.testing.assert_array_equal(found.at(0.61).v("bob.omega"), result.at(0.61).v("bob.omega"))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("q", np.zeros((41, 1))),
        ("q", np.zeros((41, 3), np.complex128)),
        ("v", np.zeros((40, 3))),
        ("t", np.zeros((41, 2))),
        ("modes", np.full((41, 1), 7)),
        ("modes", np.zeros((41, 9), np.int64)),
        ("modes", np.zeros((41, 1))),
    ],
)
def test_arrays_of_other_shapes_are_refused(
    sent: Callable[..., Path], machine: Machine, name: str, value: Any
) -> None:
    def poison(fields: dict[str, Any]) -> None:
        fields["samples"] = {**fields["samples"], name: value}

    with pytest.raises(InputError, match=rf"the array {name} of the file has the shape"):
        load_result(sent(".nc", poison), machine)


@pytest.mark.parametrize("name", ["q", "v"])
def test_a_start_of_another_shape_is_refused(
    sent: Callable[..., Path], machine: Machine, name: str
) -> None:
    def poison(fields: dict[str, Any]) -> None:
        fields["motion"][name] = np.zeros(2)

    with pytest.raises(InputError, match=rf"the array {name} of the file has the shape \(2,\)"):
        load_result(sent(".nc", poison), machine)


class Bomb:
    """Its pickle leaves a mark."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.write_text, (self.mark, "executed")


def test_pickles_in_arrays_are_not_read(
    result: Result, machine: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mark = tmp_path / "mark"
    file = io.BytesIO()
    text = np.frombuffer(b'{"array": 0}', np.uint8)
    np.savez(file, a0=np.array([Bomb(mark)], object), json=text)
    for ending in (".nc", ".zarr"):
        for module in (export, zarr_store):
            monkeypatch.setattr(module, "saved_result", lambda _: file.getvalue())
        with pytest.raises(InputError, match="is damaged"):
            load_result(result.save(tmp_path / f"run{ending}"), machine)
    assert not mark.exists()
    np.load(io.BytesIO(file.getvalue()), allow_pickle=True)["a0"]
    assert mark.exists()  # the bomb is one


@pytest.mark.parametrize(
    "content", ['{"kind": "system", "of": ["id"]}', '{"kind": "__import__", "of": ["os"]}', "[[["]
)
def test_kinds_that_are_none_of_a_result(
    result: Result, machine: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, content: str
) -> None:
    file = io.BytesIO()
    np.savez(file, json=np.frombuffer(content.encode(), np.uint8))
    monkeypatch.setattr(export, "saved_result", lambda _: file.getvalue())
    with pytest.raises(InputError, match="is damaged"):
        load_result(result.save(tmp_path / "run.nc"), machine)


def test_attributes_of_netcdf_are_texts(
    result: Result, machine: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mark = tmp_path / "mark"
    bomb = np.frombuffer(pickle.dumps(Bomb(mark)), np.uint8)
    monkeypatch.setattr(export, "signature", lambda _: bomb)
    path = result.save(tmp_path / "run.nc")
    with pytest.raises(InputError, match="not saved by you"):
        load_result(path)
    load_result(path, machine)
    assert not mark.exists()


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
    sent: Callable[..., Path], machine: Machine, tmp_path: Path
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


def test_a_user_without_a_folder_for_keys_is_told_so(
    result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "file"))
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "file"))
    path = result.save(tmp_path / "run.nc")
    with pytest.raises(InputError, match="may be your own, but no key can be kept in the user"):
        load_result(path)


def test_a_key_is_kept_where_hard_links_are_not(
    result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*names: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "data"))
    monkeypatch.setattr(os, "link", refused)
    path = result.save(tmp_path / "run.nc")
    assert (load_result(path).q("bob.phi") == result.q("bob.phi")).all()
    assert [file.name for file in (tmp_path / "data" / "linkwright").iterdir()] == ["signing_key"]


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

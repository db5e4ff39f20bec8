"""Results in files: names, units and the same bits; what is missing is told."""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codegen import Model
from codegen.errors import InputError
from runtime import load, load_result
from runtime.machine_facade import Machine
from runtime.results import export
from runtime.results.export import field_names
from runtime.results.result import Result
from runtime.results.saved_result import pack, saved_fields


@pytest.fixture(scope="module")
def swing(workshop: Path) -> Machine:
    model = Model("saved_swing", gravity=(0, -9.81))
    bob = model.body("bob", mass=2.0, inertia=0.5)
    stop = model.parameter("stop", 0.3, unit="rad")
    model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.torque("buffer", on=bob, value=-50.0 * (bob.phi - stop), when=bob.phi > stop)
    model.scene("swing", ["gravity", "buffer"], start={bob.phi: -0.4, bob.omega: 4.0})
    model.scene("hanging", ["gravity"], guess={bob.phi: -1.5})
    return load(model, "swing", folder=workshop)


@pytest.fixture(scope="module")
def result(swing: Machine) -> Result:
    return swing.simulate(1.0, 51)


@pytest.mark.parametrize("ending", [".nc", ".zarr"])
def test_a_result_comes_back_with_equal_bits(
    result: Result, swing: Machine, tmp_path: Path, ending: str
) -> None:
    found = load_result(result.save(tmp_path / f"run{ending}"), swing)
    assert len(found.events) == len(result.events) > 0
    for name, array in result.samples._asdict().items():
        np.testing.assert_array_equal(getattr(found.samples, name), array)
    np.testing.assert_array_equal(found.at(0.123).q("bob.phi"), result.at(0.123).q("bob.phi"))
    np.testing.assert_array_equal(found.resume(1.2).q("bob.phi"), result.resume(1.2).q("bob.phi"))


@pytest.mark.parametrize("ending", [".nc", ".zarr"])
def test_a_file_is_read_by_xarray(result: Result, tmp_path: Path, ending: str) -> None:
    import xarray as xr

    path = result.save(tmp_path / f"run{ending}")
    opened = xr.open_dataset(path) if ending == ".nc" else xr.open_zarr(path, consolidated=False)
    with opened as read:
        found, data = read.load(), result.data
        assert found.attrs["message"] == result.message
        assert {*found.variables} == {*data.variables}
        for name, variable in data.variables.items():
            assert found[name].dims == variable.dims
            assert found[name].values.tolist() == variable.values.tolist() or (
                variable.dtype.kind == "f"
                and np.array_equal(found[name].values, variable.values, equal_nan=True)
            )
            assert found[name].attrs.get("units") == variable.attrs.get("units")


def test_a_store_is_replaced_and_no_other_folder(result: Result, tmp_path: Path) -> None:
    place = tmp_path / "run.zarr"
    result.save(place)
    (place / "left.txt").write_text("of the older store")
    result.save(place)
    assert not (place / "left.txt").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["run.zarr"]
    mine = tmp_path / "mine.zarr"
    mine.mkdir()
    (mine / "notes.txt").write_text("mine")
    message = r"is there, and has no linkwright/zarr\.json: it is left alone"
    with pytest.raises(InputError, match=message):
        result.save(mine)
    assert (mine / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize("ending", [".csv", ".zarr"])
def test_a_write_that_fails_leaves_the_old_file(
    result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str
) -> None:
    def content() -> list[bytes | str]:
        return [p.read_bytes() if p.is_file() else p.name for p in sorted(tmp_path.rglob("*"))]

    place = result.save(tmp_path / f"run{ending}")
    before = content()

    def fail(result: Result, path: Path) -> None:
        if ending == ".zarr":
            path.mkdir()
            path /= "zarr.json"
        path.write_text("{")
        raise OSError("disk full")

    monkeypatch.setitem(export._FORMATS, ending, export._Format(fail))
    with pytest.raises(InputError, match=rf"cannot write .*run\{ending}: disk full"):
        result.save(place)
    assert content() == before


def test_a_replacement_that_a_process_did_not_finish_is_finished_by_the_next(
    result: Result, tmp_path: Path
) -> None:
    import os

    place = result.save(tmp_path / "run.zarr")
    left = tmp_path / ".linkwright-abc"
    (left / "new").mkdir(parents=True)
    place.rename(left / "old")  # the renaming at which it died
    result.save(left / "new" / "run.zarr")
    os.utime(left, (0, 0))
    result.save(tmp_path / "other.csv")
    assert load_result(place, result_machine(result)).message == result.message
    assert not left.exists()


def result_machine(result: Result) -> Machine:
    assert result._motion is not None
    return Machine(result._motion.ready.mechanism)  # type: ignore[attr-defined]


def test_a_matlab_file_has_one_struct(result: Result, tmp_path: Path) -> None:
    from scipy.io import loadmat

    path = result.save(tmp_path / "run.mat")
    found = loadmat(path, simplify_cells=True)["result"]
    assert {*found} == {"series", "names", "units", "parameters", "about"}
    assert found["series"]["bob_phi"].tolist() == result.q("bob.phi").tolist()
    assert found["series"]["hinge_fy"].tolist() == result.reaction("hinge", "fy").tolist()
    assert found["series"]["time"].tolist() == result.t.tolist()
    assert found["names"]["a_bob_phi"] == "a(bob.phi)"
    assert found["units"]["a_bob_phi"] == "rad/s^2"
    assert found["units"]["time"] == "s"
    assert found["parameters"] == {"stop": 0.3}
    assert found["about"]["model"] == "saved_swing"
    assert found["about"]["outcome"] == "OK"
    shapes = loadmat(path)["result"]["series"][0, 0]["bob_phi"][0, 0].shape
    assert shapes == (51, 1)  # a column, as MATLAB plots it


def test_names_that_matlab_accepts() -> None:
    names = ["bob.x", "bob_x", "bob x", "end", "_a", "1st", "größe.φ", "x" * 80, "x" * 81, "()"]
    found = field_names(names)
    assert found[:6] == ["bob_x", "bob_x_2", "bob_x_3", "x_end", "a", "x_1st"]
    assert found[6] == "gru00f6u00dfe_u03c6"
    assert len({*found}) == len(names)
    assert all(name.isascii() and name.isidentifier() and len(name) <= 63 for name in found)


@pytest.mark.parametrize(
    ("ending", "library"),
    [
        (".zarr", "zarr"),
        (".mat", "scipy.io"),
        (".nc", "netCDF4"),
        (".html", "bokeh"),
        (".parquet", "pyarrow"),
    ],
)
def test_a_missing_library_is_named(
    result: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str, library: str
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(InputError, match=rf"needs the library {library}.*save as \.csv"):
        result.save(tmp_path / f"run{ending}")
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(scope="module")
def dropped(workshop: Path) -> Machine:
    model = Model("older_file", gravity=(0, -9.81))
    ball = model.particle("ball", 1.0)
    rail = model.absolute("rail", ball, "x", 0.0)
    model.release(rail, when=ball.y < -0.1)
    model.scene("falls", ["gravity"], start={ball.y: 0.0, ball.vy: 0.0})
    return load(model, folder=workshop)


@pytest.mark.parametrize("t_end", [0.1, 0.5])  # before the release, and behind it
@pytest.mark.parametrize(
    "missing", [("until",), ("motion", "source", "content"), ("motion",), ("title",)]
)
def test_a_file_that_lacks_a_field(
    dropped: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, t_end: float,
    missing: tuple[str, ...],
) -> None:  # fmt: skip
    def older(result: Result) -> bytes:
        place: dict[str, Any] = saved_fields(result)
        whole = place
        for name in missing[:-1]:
            place = place[name]
        del place[missing[-1]]
        return pack(whole)

    r = dropped.simulate(t_end)
    assert len(r.reconnections) == (t_end == 0.5)
    monkeypatch.setattr(export, "saved_result", older)
    with pytest.raises(InputError, match="not written by this version of Result"):
        load_result(r.save(tmp_path / "older.nc"), dropped)

"""Results come back in any folder, by a machine that is loaded or given."""

from pathlib import Path

import pytest

from codegen.errors import InputError
from runtime import load, load_result

_MODEL = """
from linkwright import Model
model = Model("{name}", gravity=(0, -9.81))
bob = model.body("bob", mass=2.0, inertia=0.5)
hinge = model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
model.torque("damper", on=bob, value=-{damping} * bob.omega)
model.release(hinge, when=bob.phi < -0.5)
model.scene("swing", effects=["gravity", "damper"], start={{bob.phi: 0.4, bob.omega: 0.0}})
"""


def _write(folder: Path, name: str, damping: float = 0.3) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.py").write_text(_MODEL.format(name=name, damping=damping))
    return folder / f"{name}.py"


def test_a_result_comes_back_in_another_folder_and_with_a_machine_loaded_from_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _write(tmp_path / "one", "far_bob")
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
    _write(tmp_path / "one", "changed_bob")
    monkeypatch.chdir(tmp_path)
    before = load("one/changed_bob.py")
    place = before.simulate(0.1).save("far.nc")
    after = load(_write(tmp_path / "one", "changed_bob", damping=0.4))
    with pytest.raises(InputError, match=r"has changed since .*changed_bob__swing\.py computes"):
        load_result(place, after)
    assert load_result(place).q("bob.phi")[-1] != after.simulate(0.1).q("bob.phi")[-1]
    assert load_result(place, before).at(0.05).t == 0.05

"""`load` gives the machine that was asked for, whatever else has the same name."""

from pathlib import Path

from codegen import Model
from runtime import load

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
    assert fall(load(model, "fall", folder=tmp_path)) == -1.0
    assert fall(load("mm.py", "fall", folder=tmp_path)) == -9.81
    assert fall(load(model, "fall", folder=tmp_path)) == -1.0

"""Faulty model files, and names that files have: each is read, or refused in a sentence of ours."""

import warnings
from pathlib import Path

import pytest

from codegen.errors import LinkwrightError
from codegen.reading.model_file import read_model
from codegen.reading.scene_selection import valid_scenes

SOUND = """from sympy import pi, sin
from codegen import Model, t

model = Model("pendulum", gravity=(0, -9.81))
length = model.parameter("length", 1.0, unit="m", sign="positive")
bob = model.body("bob", mass=2.0, inertia=0.1)
rod = model.body("rod", mass=1.0, inertia=0.05)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-length, 0))
model.revolute("knee", bob.at(length, 0), rod.at(-length, 0))
model.torque("damper", on=bob, value=-0.3 * bob.omega)
model.spring("coil", model.ground.at(1, 0), rod.at(0, 0), stiffness=100.0, free_length=0.5)
model.force("push", on=rod, fx=sin(3 * t), fy=0, when=rod.x > 0)
model.driver("motor", bob.phi, 2 * pi * t)
model.scene("swing", effects=["gravity", "damper"], drivers=[], start={bob.phi: 0.0})
model.scene("driven", effects=["gravity", "coil", "push"], drivers=["motor"], guess={rod.phi: 0.1})
"""
ODD_FILES: dict[str, bytes | str] = {
    "exits.py": SOUND + "raise SystemExit\n",
    "recurses.py": SOUND + "def f(): f()\nf()\n",
    "no_memory.py": SOUND + "raise MemoryError\n",
    "changes_folder.py": "import os; os.chdir('/')\n" + SOUND,
    "clears_path.py": "import sys; sys.path.clear()\n" + SOUND,
    "json.py": SOUND,
    "random.py": SOUND,
    "numpy.py": SOUND,
    "codegen.py": SOUND,
    "class.py": SOUND,
    "3 d.py": SOUND,
    "a\nb.py": SOUND,
    "a{b}.py": SOUND,
    'a"b.py': SOUND,
    "mark.py": b"\xef\xbb\xbf" + SOUND.encode(),
    "wide.py": SOUND.encode("utf-16"),
    "unknown_coding.py": "# -*- coding: klingon -*-\n" + SOUND,
    "latin.py": ("# -*- coding: latin-1 -*-\n# \xe9\n" + SOUND).encode("latin-1"),
    "undeclared_latin.py": (SOUND + "x = '\xe9'\n").encode("latin-1"),
    "nul.py": SOUND.encode() + b"\0",
    "empty.py": "",
    "deep.py": "x = " + "(" * 500 + ")" * 500,
    "returns.py": SOUND.replace("\n", "\r\n"),
    "replaces.py": SOUND + "model = Model\n",
}


@pytest.mark.parametrize("name", ODD_FILES)
def test_an_odd_file_is_read_or_refused_in_sentences(name: str, tmp_path: Path) -> None:
    text, file = ODD_FILES[name], tmp_path / name
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    told: tuple[str, ...] = ("sound",)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            assert len(valid_scenes(read_model(str(file)).model, None)) == 2
        except LinkwrightError as error:
            told = error.problems
    assert told
    assert all(problem.strip() for problem in told)

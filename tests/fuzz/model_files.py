"""Model files with faults, from a seed: the texts of sound files changed at random.

A file is read and its scenes are checked. It must be accepted, or refused by an error of
Linkwright's own, soon. `ODD_FILES` are whole files that fail in ways of their own, and names that
files have.
"""

import ast
import atexit
import shutil
import string
import tempfile
import traceback
import warnings
from functools import cache
from pathlib import Path
from random import Random
from time import monotonic

import codegen
from codegen.errors import LinkwrightError
from codegen.reading.model_file import read_model
from codegen.reading.scene_selection import valid_scenes

COMPILER = Path(codegen.__file__).parent
SLOW = 20.0  # seconds after which a file counts as hanging
SOUND = """from sympy import Piecewise, cos, nan, pi, sin, sqrt
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
EXPRESSIONS = [
    *("None", "True", "0", "-1", "1e400", "10**400", "nan", "1j", "'bob'", "''", "'5'", "[1, 2]"),
    *("()", "{}", "{1, 2}", "{bob.phi: 1}", "lambda *_: None", "object()", "print", "Model", "t"),
    *("model", "model.ground", "bob", "rod", "length", "bob.phi", "bob.vx", "bob.at(1, 0)", "pi"),
    *("rod.at(t, 0)", "sin(bob.x) / 0", "sqrt(-1)", "1 / (t - t)", "b'x'", "'a\\nb'", "bob.at"),
    *("Piecewise((1, t > 1))", "cos", "-length", "bob.phi > 0", "model.gravity", "2 * bob"),
    *("model.scenes", "model.scene", "[bob, rod]", "{'bob': bob}", "(x for x in [1])", "range(3)"),
    *("bob.phi.rate", "bob.phi.diff(t)", "t ** 0.5", "t == 1", "...", "NotImplemented", "float"),
    *("bob.at(bob.x, 0)", "''.join"),
    *("Model('other').body('o', mass=1)", "Model('other').ground", "Model('other')", "1 / bob.x"),
    *("model.table('tab', [0, 1, 2, 3], [0, 1, 0, 2])", "model.table('tab', [0], [1])", "2**0.5"),
    *("(lambda: 1 / 0)()", "[].pop()", "open('no such file')", "__import__('no_module')", "y"),
    *("model.bodies['hinge']", "exit()"),
    *("bob.mass", "bob.torque(1)", "bob.circle(0.1)", "bob.polar(t)", "cos(bob.phi.rate) > 1"),
]
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


def changed(draw: Random) -> str:
    """The sound file with expressions replaced, and perhaps a statement left out or repeated."""
    tree = ast.parse(SOUND)
    if draw.random() < 0.2:
        place = draw.randrange(2, len(tree.body))
        tree.body[place : place + 1] = [tree.body[place]] * draw.choice((0, 2))
    for _ in range(draw.choice((0, 1, 1, 2))):
        holders = [node for node in ast.walk(tree) if isinstance(node, ast.Call | ast.BinOp)]
        holder = draw.choice(holders)
        new = ast.parse(draw.choice(EXPRESSIONS), mode="eval").body
        if isinstance(holder, ast.BinOp):
            setattr(holder, draw.choice(("left", "right")), new)
        elif holder.keywords and (not holder.args or draw.random() < 0.5):
            draw.choice(holder.keywords).value = new
        elif holder.args:
            holder.args[draw.randrange(len(holder.args))] = new
    text = ast.unparse(tree)
    if draw.random() < 0.2:
        place = draw.randrange(len(text))
        text = text[:place] + draw.choice(string.printable) + text[place + draw.randrange(4) :]
    return text


def fault(file: Path) -> str:
    """What is wrong with the answer to a model file; nothing if it is as it should be."""
    began = monotonic()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            valid_scenes(read_model(str(file)).model, None)
    except LinkwrightError as error:
        if not all(problem.strip() for problem in error.problems):
            return "an error without a sentence"
        return _ours(error.__cause__, file)
    except BaseException as error:
        return _line(error)
    spent = monotonic() - began
    return f"took {spent:.0f} s" if spent > SLOW else ""


def _ours(error: BaseException | None, file: Path) -> str:
    """The error of a file's statement, if what it calls is the compiler's and fails within."""
    frames = [] if error is None else traceback.extract_tb(error.__traceback__)
    own = [k for k, frame in enumerate(frames) if frame.filename == str(file)]
    called = frames[own[-1] + 1 :] if own else []
    of_compiler = called and Path(called[0].filename).is_relative_to(COMPILER)
    return _line(error) if error is not None and of_compiler else ""


def _line(error: BaseException) -> str:
    frame = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} at {Path(frame.filename).name}:{frame.lineno}"


def written(folder: Path, name: str, text: bytes | str) -> str:
    """What is wrong with the answer to a file of that name and text."""
    file = folder / name
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    try:
        return fault(file)
    finally:
        file.unlink()


@cache
def folder() -> Path:
    """A folder for the files of a campaign."""
    path = tempfile.mkdtemp()
    atexit.register(shutil.rmtree, path, ignore_errors=True)
    return Path(path)


def judge(random: Random) -> str | None:
    """What is wrong about the answer to one file; None: nothing."""
    text = changed(random)
    found = written(folder(), "changed.py", text)
    return f"{found}\n{text}" if found else None

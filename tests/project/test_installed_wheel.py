"""The wheel in an environment elsewhere: its types, its modules, and what it says of itself."""

import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import venv
import zipfile
from email import message_from_bytes
from pathlib import Path

import pytest
from packaging.requirements import Requirement

_MODEL = """
from linkwright import Model
model = Model("outside", gravity=(0, -9.81))
bob = model.body("bob", mass=2.0, inertia=0.1)
model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
model.scene("swing", effects=["gravity"], start={bob.phi: 0.0})
"""
_USE = """
import linkwright as lw

machine = lw.load("outside.py")
reveal_type(machine.simulate(1.0).q("bob.phi"))
reveal_type(lw.load_case("case.yaml").analyse())
reveal_type(lw.Model("a").body("b", mass=1.0, inertia=1.0))
machine.simulate("long")
"""


@pytest.fixture(scope="module")
def environment(wheel: zipfile.ZipFile, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The Python of an environment with the wheel, and with the libraries of this one."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False)
    python = folder / ("Scripts" if os.name == "nt" else "bin") / "python"
    code = "import sysconfig; print(sysconfig.get_path('purelib'))"
    site = Path(subprocess.check_output([python, "-c", code], text=True).strip())
    wheel.extractall(site)
    (site / "libraries.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return python


def test_the_archive_builds_the_same_wheel(
    archives: Path, wheel: zipfile.ZipFile, tmp_path: Path
) -> None:
    (path,) = archives.glob("*.tar.gz")
    with tarfile.open(path) as archive:
        archive.extractall(tmp_path, filter="data")
    (source,) = tmp_path.iterdir()
    (tmp_path / "dist").mkdir()
    build = "import sys; from hatchling.build import build_wheel; build_wheel(sys.argv[1])"
    command = [sys.executable, "-c", build, tmp_path / "dist"]
    done = subprocess.run(command, cwd=source, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (built,) = (tmp_path / "dist").glob("*.whl")
    assert built.name == Path(str(wheel.filename)).name
    with zipfile.ZipFile(built) as other:
        assert other.namelist() == wheel.namelist()
        assert [n for n in wheel.namelist() if other.read(n) != wheel.read(n)] == []


def test_the_wheel_says_what_it_requires(wheel: zipfile.ZipFile, root: Path) -> None:
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    (name,) = (name for name in wheel.namelist() if name.endswith(".dist-info/METADATA"))
    about = message_from_bytes(wheel.read(name))
    assert about["Requires-Python"] == ">=3.11"
    assert {*about.get_all("Provides-Extra", [])} == {*project["optional-dependencies"]}
    required = [Requirement(text) for text in about.get_all("Requires-Dist", [])]
    always = {of.name.lower() for of in required if of.marker is None}
    assert always == {Requirement(line).name.lower() for line in project["dependencies"]}


def test_every_extra_is_documented(root: Path) -> None:
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    page = (root / "docs" / "start" / "installing.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \| [^|]*\w[^|]* \|", page, re.MULTILINE)
    assert sorted(rows) == sorted(project["optional-dependencies"])


def test_a_model_is_built_and_a_case_read_elsewhere(environment: Path, tmp_path: Path) -> None:
    (tmp_path / "outside.py").write_text(_MODEL)
    (tmp_path / "case.yaml").write_text("model: outside.py\nrun: {t_end: 1 s}\n")
    code = (
        "import linkwright as lw, codegen, runtime\n"
        "case = lw.load_case('case.yaml')\n"
        "print(lw.__file__, codegen.__file__, runtime.__file__, case.machine().path, sep='\\n')"
    )
    done = subprocess.run(
        [environment, "-W", "error", "-c", code],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    *modules, built = map(Path, done.stdout.split())
    assert all(path.is_relative_to(environment.parent.parent) for path in modules)
    assert built == tmp_path / "generated" / "outside__swing.py"


@pytest.mark.slow
def test_types_are_seen_from_outside(
    environment: Path, wheel: zipfile.ZipFile, tmp_path: Path
) -> None:
    assert {f"{name}/py.typed" for name in ("linkwright", "codegen", "runtime")} <= {
        *wheel.namelist()
    }
    (tmp_path / "use.py").write_text(_USE)
    command = [sys.executable, "-m", "mypy", "--python-executable", str(environment), "use.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    lines = [line.partition(" ")[2] for line in done.stdout.splitlines()]
    assert [re.sub(r"\[.*", "", line) for line in lines[:3]] == [
        'note: Revealed type is "numpy.ndarray',
        'note: Revealed type is "runtime.results.result.Result"',
        'note: Revealed type is "codegen.declare.body.Body"',
    ], done.stdout + done.stderr
    assert 'Argument 1 to "simulate" of "Machine" has incompatible type "str"' in lines[3]

"""What a wheel and a source archive hold, also of a tree with files that git does not know."""

import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

from codegen.files.library_folders import LIBRARY, is_checkout, methods_folder, models_folder


def test_a_wheel_has_three_names_at_the_top(wheel: zipfile.ZipFile) -> None:
    top = {name.partition("/")[0] for name in wheel.namelist()}
    assert {name for name in top if not name.endswith(".dist-info")} == {
        "codegen",
        "linkwright",
        "runtime",
    }
    (entry,) = (name for name in wheel.namelist() if name.endswith("entry_points.txt"))
    assert "linkwright = linkwright.command_line:main" in wheel.read(entry).decode()


def test_a_wheel_has_every_file_that_git_knows_of_its_packages(
    root: Path, project_files: tuple[Path, ...], wheel: zipfile.ZipFile
) -> None:
    names = {path.relative_to(root).as_posix() for path in project_files}
    moved = {n: n for n in names if n.startswith(("codegen/", "linkwright/", "runtime/"))}
    moved |= {n: f"runtime/{n}" for n in names if n.startswith("generated/methods/")}
    held = {name for name in wheel.namelist() if ".dist-info/" not in name}
    assert held == set(moved.values())
    assert len(held) > 300
    assert all(wheel.read(place) == (root / name).read_bytes() for name, place in moved.items())


def test_a_source_archive_has_what_git_knows(
    root: Path, project_files: tuple[Path, ...], archives: Path
) -> None:
    (path,) = archives.glob("*.tar.gz")
    with tarfile.open(path) as archive:
        held = {member.name.partition("/")[2] for member in archive if member.isfile()}
    names = {path.relative_to(root).as_posix() for path in project_files}
    names = {name for name in names if not name.startswith(".ci/")}
    assert held - {"PKG-INFO"} == names


def test_an_installed_wheel_finds_its_methods_and_nothing_that_is_not_its_own(
    wheel: zipfile.ZipFile, tmp_path: Path
) -> None:
    """Of other packages beside it, one may be called `models` or `generated`."""
    wheel.extractall(tmp_path)
    for name in ("models/pump.py", "generated/methods/dop853.py"):
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).write_text("raise SystemExit('of another package')")
    code = (
        "import linkwright\n"
        "from codegen.files.library_folders import is_checkout, methods_folder, models_folder\n"
        "print(linkwright.__file__, is_checkout(), models_folder(), methods_folder(), sep='\\n')\n"
        "linkwright.load('pump')"
    )
    done = subprocess.run(
        [sys.executable, "-P", "-c", f"import sys; sys.path.insert(0, {str(tmp_path)!r})\n{code}"],
        cwd=tmp_path.parent,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.splitlines() == [
        str(tmp_path / "linkwright" / "__init__.py"),
        "False",
        "None",
        str(tmp_path / "runtime" / "generated" / "methods"),
    ]
    assert "There is no model 'pump'" in done.stderr
    assert "come with the checkout, not with a wheel" in done.stderr


def test_a_checkout_has_its_models_and_methods_beside_the_packages(root: Path) -> None:
    assert root == LIBRARY
    assert is_checkout()
    assert models_folder() == root / "models"
    assert methods_folder() == root / "generated" / "methods"

"""The wheel and the source archive of a copy of the project, built once."""

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

UNTRACKED = (
    "codegen/mine.py",
    "codegen/elements/my joint[1].py",
    "generated/pump__run.py",
    "generated/methods/mine.py",
    "linkwright/mine/more.py",
    "models/pump.py",
    "runtime/mine.txt",
    "notes.md",
)
HIDDEN = {"runtime/private.py": ".git/info/exclude", "linkwright/hidden.py": ".git/ignored"}
"""Untracked files, and the list of a user's own that hides them from git."""
BUILD = """
import sys
from hatchling.build import build_sdist, build_wheel
build_wheel(sys.argv[1])
build_sdist(sys.argv[1])
"""


@pytest.fixture(scope="session")
def archives(
    root: Path, project_files: tuple[Path, ...], tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """A folder with the wheel and the archive of a copy of the project."""
    if shutil.which("git") is None:
        pytest.skip("git tells which files are the project's")
    tree, out = tmp_path_factory.mktemp("tree"), tmp_path_factory.mktemp("archives")
    for path in project_files:
        copy = tree / path.relative_to(root)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(path.read_bytes())
    for command in (["init", "--quiet"], ["add", "--all"]):
        subprocess.run(["git", *command], cwd=tree, check=True)
    ignored = ["config", "core.excludesFile", str(tree / ".git" / "ignored")]
    subprocess.run(["git", *ignored], cwd=tree, check=True)
    for name, listed_in in HIDDEN.items():
        with (tree / listed_in).open("a") as listing:
            listing.write(f"/{name}\n")
    for name in (*UNTRACKED, *HIDDEN):
        (tree / name).parent.mkdir(exist_ok=True)
        (tree / name).write_text("mine = 1\n")
    done = subprocess.run(
        [sys.executable, "-c", BUILD, str(out)],
        cwd=tree,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return out


@pytest.fixture(scope="session")
def wheel(archives: Path) -> zipfile.ZipFile:
    (path,) = archives.glob("*.whl")
    return zipfile.ZipFile(path)

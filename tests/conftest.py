"""What every test stands on: no display, reproducible examples, the project's own files."""

import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

os.environ.setdefault("MPLBACKEND", "Agg")

# Kernels compile inside the first example, so no example has a deadline. In CI the examples are
# the same each time; on a developer's machine they differ and failures are remembered.
settings.register_profile("developer", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, database=None)
settings.load_profile("ci" if os.environ.get("CI") else "developer")

ROOT = Path(__file__).resolve().parent.parent

# A file's tests share studies, scenes and loaded machines that cost seconds to make: one worker
# runs them all. These files read the same scenes, so one worker runs the three.
SCENES = "tests/codegen/conftest.py"
TOGETHER = {
    "tests/codegen/emit/test_kernels.py": SCENES,
    "tests/codegen/emit/test_module.py": SCENES,
    "tests/codegen/test_legal.py": SCENES,
}


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """As `--dist=loadfile`, with the files of `TOGETHER` taken for one."""
    if config.getoption("dist") != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class Sharing(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = super()._split_scope(nodeid)
            return TOGETHER.get(file, file)

    return Sharing(config, log)


@pytest.fixture(scope="session")
def root() -> Path:
    """The folder of pyproject.toml."""
    return ROOT


@pytest.fixture(scope="session")
def project_files() -> tuple[Path, ...]:
    """Every file of the project: what git knows or would add, or all there is without git."""
    git = shutil.which("git")
    if git and (ROOT / ".git").exists():
        listing = subprocess.run(
            [git, "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT,
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        candidates = [ROOT / name for name in listing.split("\0") if name]
    else:
        candidates = [
            path
            for path in ROOT.rglob("*")
            if not {"__pycache__", "figures", "results"} & set(path.relative_to(ROOT).parts)
            and not any(
                part.startswith(".") and part != ".ci" for part in path.relative_to(ROOT).parts[:-1]
            )
        ]
    return tuple(sorted(path for path in candidates if path.is_file()))

"""What every test stands on: no display, reproducible examples, the project's own files."""

import gc
import os
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
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


def pytest_addoption(parser: pytest.Parser) -> None:
    """``--unroll never``: machines of the library run with kernels in loops over tables."""
    choices = ("auto", "always", "never")
    parser.addoption("--unroll", default="auto", choices=choices, help="form of kernels")


def pytest_configure(config: pytest.Config) -> None:
    """Without pytest's cache (`-p no:cacheprovider`) tests compile scenes in a folder that goes."""
    if config.pluginmanager.hasplugin("cacheprovider"):
        return
    folder = Path(tempfile.mkdtemp(prefix="linkwright-"))
    config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))

    def mkdir(name: str) -> Path:
        (folder / name).mkdir(exist_ok=True)
        return folder / name

    config.cache = SimpleNamespace(mkdir=mkdir)


@pytest.fixture(scope="session", autouse=True)
def form_of_kernels(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[None]:
    """With ``--unroll``, machines of the library are built anew in a folder of the session."""
    unroll = request.config.getoption("--unroll")
    if unroll == "auto":
        yield
        return
    from tests.unrolling import built_with

    with built_with(unroll, tmp_path_factory.mktemp("generated")):
        yield


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

    # The order is that of `pytest_collection_modifyitems`.
    config.option.loadscopereorder = False
    return Sharing(config, log)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Files with slow tests go first, then those with many: workers end at about the same time."""
    if not hasattr(config, "workerinput"):
        return
    tests = Counter(item.path for item in items)
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: (item.path not in slow, -tests[item.path], item.path))


def pytest_collection_finish() -> None:
    """The collector leaves alone what was imported, and runs less often: 7 % of SymPy's time."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)


@pytest.fixture(autouse=True)
def figures_end_with_their_test() -> Iterator[None]:
    """Pyplot keeps figures until they are closed, and warns of more than twenty."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


@pytest.fixture(scope="module", autouse=True)
def caches_end_with_their_module(request: pytest.FixtureRequest) -> Iterator[None]:
    """What the tests of a file share goes with it: a worker runs hundreds of files."""
    yield
    for value in vars(request.module).values():
        if hasattr(value, "cache_clear") and value.__module__ == request.module.__name__:
            value.cache_clear()


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

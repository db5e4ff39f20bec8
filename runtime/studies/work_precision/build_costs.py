"""Times of building a scene: derive, lower, emit, compile, load; once each.

The scene is built anew in a temporary folder, since build results are kept. A load that finds
machine code in numba's cache is timed in a process of its own.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING

from codegen.errors import SceneError

if TYPE_CHECKING:
    from codegen import Model, Scene
    from codegen.generated_files.build_report import SceneReport

WARM = "load, warm"
_LOAD = """
import sys, pathlib, time
import numba
from codegen.artefact import import_generated
began = time.perf_counter()
import_generated(pathlib.Path(sys.argv[1]))
sys.stdout.write(repr(time.perf_counter() - began))
"""


def build_costs(
    model: "Model", scene: "Scene", companions: Collection[str] = ("tangents", "reduced")
) -> dict[str, float]:
    """Stage → wall-clock seconds, in order, from the declared model on.

    Companion modules (derivatives, which implicit methods take, and reduced equations) have stages
    of their own, which follow where the scene has them; files are compiled concurrently.

    Parameters
    ----------
    companions
        Those that are built beside the scene's own module.
    """
    with tempfile.TemporaryDirectory() as folder:
        report = _built(model, scene, Path(folder) / "generated", companions)
        seconds = {stage: time for stage, time in report.seconds.items() if stage != "read"}
        for companion in report.companions:
            seconds |= {
                stage if stage != "compile" else f"compile {companion.title}": time
                for stage, time in companion.seconds.items()
            }
        return seconds | {WARM: _warm_load(report.path)}


def _built(
    model: "Model", scene: "Scene", folder: Path, companions: Collection[str]
) -> "SceneReport":
    from codegen import build

    tangents = "tangents" in companions
    if "reduced" in companions:
        try:
            return build(model, scene, folder, tangents=tangents, reduced=True).scenes[0]
        except SceneError:  # a scene without reduced equations: sticking by the force of a reaction
            pass
    return build(model, scene, folder, tangents=tangents).scenes[0]


def _warm_load(path: Path) -> float:
    root = Path(__file__).resolve().parents[3]
    paths = os.pathsep.join(filter(None, [str(root), os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        [sys.executable, "-c", _LOAD, str(path)],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=True,
    )
    return float(done.stdout)

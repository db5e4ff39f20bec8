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

_LOAD = """
import sys, pathlib, time
import numba
from codegen.files.generated_modules import import_generated
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
    """
    from codegen import build

    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "generated"
        tangents, reduced = "tangents" in companions, "reduced" in companions
        try:
            report = build(model, scene, out, tangents=tangents, reduced=reduced).scenes[0]
        except SceneError:  # a scene without reduced equations: sticking by the force of a reaction
            if not reduced:
                raise
            report = build(model, scene, out, tangents=tangents).scenes[0]
        seconds = {stage: time for stage, time in report.seconds.items() if stage != "read"}
        for companion in report.companions:
            seconds |= {
                stage if stage != "compile" else f"compile {companion.title}": time
                for stage, time in companion.seconds.items()
            }
        return seconds | {"load, warm": _warm_load(report.path)}


def _warm_load(path: Path) -> float:
    root = Path(__file__).resolve().parents[3]
    paths = os.pathsep.join(filter(None, [str(root), os.environ.get("PYTHONPATH")]))
    environment = {**os.environ, "PYTHONPATH": paths}
    command = [sys.executable, "-P", "-c", _LOAD, str(path)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout)

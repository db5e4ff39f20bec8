"""What a scene costs before it runs: derived, lowered, written, compiled, loaded; once each.

It is built anew in a folder of its own, since what is built is kept. A load that finds machine code
in numba's cache is timed in a process of its own.
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
    """Stage → seconds that pass, in order, from the declared model on.

    Derivatives, which implicit methods take, and reduced equations have files of their own; their
    stages are told apart where the scene has them. Files are compiled side by side.

    Parameters
    ----------
    companions
        Which of these files are built beside the scene's own.
    """
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "generated"
        report = _built(model, scene, place, companions)
        seconds = {stage: took for stage, took in report.seconds.items() if stage != "read"}
        for companion in report.companions:
            seconds |= {
                stage if stage != "compile" else f"compile {companion.title}": took
                for stage, took in companion.seconds.items()
            }
        return seconds | {WARM: _warm(report.path)}


def _built(
    model: "Model", scene: "Scene", place: Path, companions: Collection[str]
) -> "SceneReport":
    from codegen import build

    tangents = "tangents" in companions
    if "reduced" in companions:
        try:
            return build(model, scene, place, tangents=tangents, reduced=True).scenes[0]
        except SceneError:  # frictions that stick by the force of a reaction
            pass
    return build(model, scene, place, tangents=tangents).scenes[0]


def _warm(path: Path) -> float:
    folder = Path(__file__).resolve().parents[3]
    paths = os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        [sys.executable, "-c", _LOAD, str(path)],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=True,
    )
    return float(done.stdout)

"""A study as JSON lines: one per run, each with all that is needed to understand it alone."""

import json
import platform
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from codegen import __version__
from runtime.results.samples import plain
from runtime.studies.work_precision.diagram import Point, Setting, WorkPrecision
from runtime.studies.work_precision.interpretation import effectivity, slope

LIBRARIES = ("numba", "llvmlite", "numpy", "scipy", "sympy")
_COMMON = ("model", "scene", "model_sha256", "t_start", "t_end", "instants", "environment")


def environment() -> dict[str, str]:
    """Processor, operating system and versions: name → text."""
    facts = {
        "machine": processor(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "linkwright": __version__,
    }
    for name in LIBRARIES:
        with suppress(PackageNotFoundError):  # a library in a bundle may come without metadata
            facts[name] = version(name)
    return facts


def processor() -> str:
    """Name of the processor."""
    information = Path("/proc/cpuinfo")
    if information.is_file():
        for line in information.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def records(study: WorkPrecision) -> Iterator[dict[str, Any]]:
    """One mapping per run, per refused setting, and per modelling choice that did not run."""
    common = {name: getattr(study, name) for name in _COMMON} | {
        "artefact_sha256": study.artefact,
        "scales": {scale.name: scale.value for scale in study.quantities},
        "reference": study.reference.source,
        "independent": study.reference.independent,
        "floor": study.reference.floor,
        "energy_against": study.energy,
    }
    for line in study.lines:
        about = {**common, **asdict(line.setting), "choice": ""}
        of_line = {"slope": slope(line), "effectivity": effectivity(line)}
        if line.refused:
            yield plain({**about, "outcome": "REFUSED", "message": line.refused})
        for point in line.points:
            yield plain({**about, **_run(study, point), **of_line})
    for choice in study.choices:
        setting = asdict(choice.setting or Setting(""))
        about = {**common, "scene_run": choice.scene, **setting, "choice": choice.title}
        refusal = {"outcome": "REFUSED", "message": choice.reason}
        yield plain({**about, **(_run(study, choice.point) if choice.point else refusal)})


def write_records(study: WorkPrecision, path: Path) -> Path:
    """Write them, a line each; returns the path."""
    lines = (json.dumps(record, allow_nan=False) for record in records(study))
    path.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
    return path


def _run(study: WorkPrecision, point: Point) -> dict[str, Any]:
    positions = [scale for scale in study.quantities if scale.group == "positions"]
    atol = {scale.name: point.rtol * min(1.0, scale.value) for scale in positions}
    return {**asdict(point), "atol": atol, "digits": point.digits}

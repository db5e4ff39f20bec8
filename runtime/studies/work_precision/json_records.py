"""A study as JSON lines: one a run, each with all that it takes to be understood alone."""

import json
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from runtime.results.json_values import plain
from runtime.studies.work_precision.diagram import Point, Setting, WorkPrecision
from runtime.studies.work_precision.interpretation import effectivity, slope


def records(told: WorkPrecision) -> Iterator[dict[str, Any]]:
    """One mapping a run; one for a setting that was refused and for a choice that did not run."""
    about = {
        "model": told.model,
        "scene": told.scene,
        "model_sha256": told.model_sha256,
        "artefact_sha256": told.artefact,
        "t_start": told.t_start,
        "t_end": told.t_end,
        "instants": told.instants,
        "scales": {scale.name: scale.value for scale in told.quantities},
        "reference": told.reference.source,
        "independent": told.reference.independent,
        "floor": told.reference.floor,
        "energy_against": told.energy,
        "environment": told.environment,
    }
    for line in told.lines:
        of_line = {"slope": slope(line), "effectivity": effectivity(line)}
        if line.refused:
            yield plain({**about, **_how(line.setting), "choice": "", "outcome": "REFUSED",
                         "message": line.refused})  # fmt: skip
        for point in line.points:
            yield plain(
                {**about, **_how(line.setting), "choice": "", **_run(told, point), **of_line}
            )
    for choice in told.choices:
        how = {**_how(choice.setting or Setting("")), "choice": choice.title}
        run = (
            {"outcome": "REFUSED", "message": choice.reason}
            if choice.point is None
            else _run(told, choice.point)
        )
        yield plain({**about, "scene_run": choice.scene, **how, **run})


def write_records(told: WorkPrecision, path: Path) -> Path:
    """Write them, a line each; returns the path."""
    lines = (json.dumps(record, allow_nan=False) for record in records(told))
    path.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
    return path


def _how(setting: Setting) -> dict[str, Any]:
    return dict(setting._asdict())


def _run(told: WorkPrecision, point: Point) -> dict[str, Any]:
    entries = asdict(point)
    entries["atol"] = {
        scale.name: point.rtol * min(1.0, scale.value)
        for scale in told.quantities
        if scale.group == "positions"
    }
    return {**entries, "digits": point.digits}

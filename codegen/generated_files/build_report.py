"""The report of a build: for each scene the file, its counts and its times."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from codegen.check.redundancy import Findings
from codegen.derive.equations import Equations
from codegen.generated_files.companions import COMPANIONS
from codegen.generated_files.generated_file import File
from codegen.readers.calls import readable_class


@dataclass(frozen=True, kw_only=True)
class FileReport:
    """A generated file.

    Attributes
    ----------
    path, changed, digest
        The file, whether it is new, and the SHA-256 of its text.
    operations
        Kernel → arithmetic operations.
    seconds
        Stage → wall time.
    """

    path: Path
    changed: bool
    digest: str
    operations: dict[str, int]
    seconds: dict[str, float]


@dataclass(frozen=True, kw_only=True)
class CompanionReport(FileReport):
    """A companion module; `title` is its content, for people."""

    title: str


@dataclass(frozen=True, kw_only=True)
class SceneReport(FileReport):
    """The files of one scene.

    Attributes
    ----------
    tangents, reduced, picture
        Its companion modules, if it has them: exact derivatives, reduced coordinates, geometry.
    notes
        Remarks for the modeller: constraints that are redundant near the start values.
    """

    model: str
    scene: str
    bodies: tuple[str, ...]
    coordinates: int
    constraints: int
    degrees_of_freedom: int
    states: tuple[str, ...]
    effects: tuple[str, ...]
    left_out: tuple[str, ...]
    strategy: str | None
    tangents: CompanionReport | None = None
    reduced: CompanionReport | None = None
    picture: CompanionReport | None = None
    notes: tuple[str, ...] = ()

    @property
    def companions(self) -> tuple[CompanionReport, ...]:
        """Its companion modules."""
        return tuple(filter(None, (self.tangents, self.reduced, self.picture)))


@readable_class
@dataclass(frozen=True)
class BuildReport:
    """The result of `build`; `stale` lists the files that a check found out of date."""

    scenes: tuple[SceneReport, ...]
    stale: tuple[Path, ...] = ()

    @property
    def paths(self) -> tuple[Path, ...]:
        """The generated files."""
        return tuple(scene.path for scene in self.scenes)


def report(
    equations: Equations, strategy: str | None, findings: Findings, file: File
) -> SceneReport:
    """The report of one scene."""
    n = len(equations.coordinates) - len(equations.states)
    companions: dict[str, Any] = {
        kind.name: CompanionReport(title=kind.title, **_facts(file.companions[kind.name]))
        for kind in COMPANIONS
        if kind.name in file.companions
    }
    return SceneReport(
        **_facts(file), **companions, model=equations.model, scene=equations.scene.name,
        bodies=equations.bodies, coordinates=n,
        constraints=sum(len(c.statement.rows) for c in equations.constraints),
        degrees_of_freedom=n - findings.independent, strategy=strategy, notes=findings.notes,
        states=tuple(state.name for state in equations.states),
        effects=tuple(e.name for e in equations.effects),
        left_out=tuple(name for name, _ in equations.left_out),
    )  # fmt: skip


def _facts(file: File) -> dict[str, Any]:
    facts = {name: getattr(file, name) for name in ("path", "changed", "digest", "operations")}
    return {**facts, "seconds": file.clock.seconds}

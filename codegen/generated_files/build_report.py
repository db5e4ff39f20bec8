"""The report of a build: for each scene the file, its counts and its times."""

from dataclasses import dataclass
from pathlib import Path

from codegen.check.redundancy import Findings
from codegen.derive.equations import Equations
from codegen.generated_files.companions import COMPANIONS
from codegen.generated_files.generated_file import File
from codegen.lower.kernels.scene_kernels import Lowered
from codegen.lower.operation_count import operations


@dataclass(frozen=True)
class CompanionReport:
    """A companion module; attributes as in `SceneReport`.

    Attributes
    ----------
    title
        Its content, for people.
    """

    title: str

    path: Path
    changed: bool
    digest: str
    operations: dict[str, int]
    seconds: dict[str, float]


@dataclass(frozen=True)
class SceneReport:
    """The files of one scene.

    Attributes
    ----------
    path, changed, digest
        The generated file, whether it is new, and the SHA-256 of its text.
    operations
        Kernel → arithmetic operations.
    seconds
        Stage → wall time.
    tangents, reduced
        Its companion modules, if it has them: exact derivatives, reduced coordinates.
    notes
        Remarks for the modeller: constraints that are redundant near the start values.
    """

    model: str
    scene: str
    path: Path
    changed: bool
    digest: str
    bodies: tuple[str, ...]
    coordinates: int
    constraints: int
    degrees_of_freedom: int
    effects: tuple[str, ...]
    left_out: tuple[str, ...]
    strategy: str | None
    operations: dict[str, int]
    seconds: dict[str, float]
    tangents: CompanionReport | None = None
    reduced: CompanionReport | None = None
    notes: tuple[str, ...] = ()

    @property
    def companions(self) -> tuple[CompanionReport, ...]:
        """Its companion modules."""
        return tuple(report for report in (self.tangents, self.reduced) if report)


@dataclass(frozen=True)
class BuildReport:
    """The result of `build`; `stale` lists the files that a check found out of date."""

    scenes: tuple[SceneReport, ...]
    stale: tuple[Path, ...] = ()

    @property
    def paths(self) -> tuple[Path, ...]:
        """The generated files."""
        return tuple(scene.path for scene in self.scenes)


def report(equations: Equations, lowered: Lowered, findings: Findings, file: File) -> SceneReport:
    """The report of one scene."""
    n = len(equations.coordinates)
    m = sum(len(c.statement.rows) for c in equations.constraints)
    program = lowered.program
    return SceneReport(
        equations.model,
        equations.scene.name,
        file.path,
        file.changed,
        file.digest,
        equations.bodies,
        n,
        m,
        n - findings.independent,
        tuple(e.name for e in equations.effects),
        tuple(name for name, _ in equations.left_out),
        lowered.strategy,
        {k.name: operations(program, k) for k in program.kernels},
        file.clock.seconds,
        notes=findings.notes,
        **{
            kind.name: _companion_report(kind.title, file.companions[kind.name])
            for kind in COMPANIONS
            if kind.name in file.companions
        },
    )


def _companion_report(title: str, file: File) -> CompanionReport:
    seconds = file.clock.seconds
    return CompanionReport(title, file.path, file.changed, file.digest, file.operations, seconds)

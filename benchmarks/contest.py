"""Machines against other tools at equal error: every tool in its own process, one after the other.

The machine is not always as fast, and a contest takes a while: before and after each process the
floor of the slider-crank is timed, and factors between contestants are corrected by it. Times are
told as they were measured.
"""

import json
import math
import os
import subprocess
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

from benchmarks import ours
from benchmarks.precision import Point, best_time, time_to
from benchmarks.problems import PROBLEMS, Problem

ROOT = Path(__file__).resolve().parent.parent
TARGETS = (1e-6, 1e-9)
LIMIT = 240.0
"""Seconds that a tool has for a problem; what it found until then counts."""
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
OURS, FLOOR = "linkwright", "floor"


@dataclass(frozen=True)
class Peer:
    """A tool: how it is installed, what it is, and which problems it has."""

    package: str
    multibody: bool
    problems: tuple[str, ...]


LOOPS = tuple(name for name in PROBLEMS if name.startswith("n_four_bar_"))
PEERS = {
    "exudyn": Peer("exudyn", True, ("slider_crank", "andrews", *LOOPS, "chain_10")),
    "pinocchio": Peer("pin", True, ("slider_crank", "chain_10")),
    "mujoco": Peer("mujoco", True, ("slider_crank", "chain_10")),
    "pydy": Peer("pydy cython", True, ("slider_crank",)),
    "scipy": Peer("scipy sympy", False, ("slider_crank", "andrews")),
    "casadi": Peer("casadi", False, ("slider_crank", "andrews", "chain_10")),
    "numbalsoda": Peer("numbalsoda", False, ("slider_crank", "andrews")),
    "heyoka": Peer("heyoka", False, ("slider_crank", "andrews", "chain_10")),
}


@dataclass
class Contest:
    """All that was measured of a problem.

    Attributes
    ----------
    problem
        Its name.
    points
        Of everybody.
    paces
        Contestant → ms of the slider-crank's floor about the time that it ran.
    versions
        Of the tools.
    missing
        Contestant → why it has no points, or not all.
    checks
        What else was looked at, by name.
    """

    problem: str
    points: list[Point] = field(default_factory=list)
    paces: dict[str, float] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)
    checks: dict[str, float] = field(default_factory=dict)

    def of(self, contestant: str, method: str | None = None) -> list[Point]:
        """The points of one, or of one method of it."""
        return [
            p
            for p in self.points
            if p.contestant == contestant and (method is None or p.method == method)
        ]

    def least(self, contestant: str, error: float) -> tuple[float, str]:
        """Its best time to an error, ms, and by which method."""
        return best_time(error, self.of(contestant))

    def factor(self, contestant: str, other: str, method: str, error: float) -> float:
        """How many times longer it takes than a method of another, at the same pace."""
        theirs = self.least(contestant, error)[0] / self.paces[contestant]
        return theirs / (time_to(error, self.of(other, method)) / self.paces[other])

    def write(self, path: Path) -> None:
        """As JSON, a point a line."""
        path.parent.mkdir(parents=True, exist_ok=True)
        told = {name: value for name, value in asdict(self).items() if name != "points"}
        rows = []
        for point in self.points:
            error = point.error if math.isfinite(point.error) else None
            rows.append("  " + json.dumps({**asdict(point), "error": error}, ensure_ascii=False))
        head = json.dumps(told, indent=1, ensure_ascii=False)[:-2]
        path.write_text(f'{head},\n "points": [\n' + ",\n".join(rows) + "\n ]\n}\n", "utf-8")


def read(path: Path) -> Contest:
    """What `Contest.write` wrote."""
    found = json.loads(path.read_text(encoding="utf-8"))
    rows = found.pop("points")
    for row in rows:
        row["error"] = math.inf if row["error"] is None else row["error"]
    return Contest(**found, points=[Point(**row) for row in rows])


def hold(
    problem: Problem, folder: Path, python: str, before: Contest | None, rounds: int
) -> Contest:
    """Ours and the floors, and the tools, unless their part is taken from an earlier contest."""
    contest = Contest(problem.name)
    entry = ours.ENTRIES[problem.name]
    pace = ours.pace()
    contest.points = ours.measure(entry, folder, rounds)
    after = ours.pace()
    contest.paces = dict.fromkeys((OURS, FLOOR), (pace + after) / 2)
    if problem.name in LOOPS:
        for tolerance in (1e-6, 1e-9):
            apart, energy = ours.checked_branch(entry, folder, tolerance)
            contest.checks[f"cranks apart at {tolerance:.0e}"] = apart
            contest.checks[f"energy at {tolerance:.0e}"] = energy
    for name, peer in PEERS.items():
        if problem.name not in peer.problems:
            continue
        if before is not None:
            _carry_over(name, before, contest)
            continue
        pace = ours.pace()
        ask(name, problem, python, contest)
        contest.paces[name] = (pace + ours.pace()) / 2
    return contest


def _carry_over(name: str, before: Contest, contest: Contest) -> None:
    contest.points += before.of(name)
    for told, kept in (
        (before.paces, contest.paces),
        (before.missing, contest.missing),
    ):
        if name in told:
            kept[name] = told[name]  # type: ignore[assignment]  # each from its own table
    contest.versions |= before.versions


def ask(name: str, problem: Problem, python: str, contest: Contest) -> None:
    """A tool's process."""
    settings = {**os.environ, **dict.fromkeys(THREADS, "1"), "PYTHONPATH": str(ROOT)}
    command = [python, "-m", f"benchmarks.peers.{name}", problem.name]
    try:
        done = subprocess.run(
            command, cwd=ROOT, env=settings, capture_output=True, timeout=LIMIT, check=False
        )
        said, told = done.stdout, done.stderr.decode(errors="replace").strip()
        failed, late = done.returncode != 0, False
    except subprocess.TimeoutExpired as reason:
        said, told, failed, late = reason.stdout or b"", "", False, True
    hear(said.decode(errors="replace").splitlines(), contest)
    if failed and ("ModuleNotFoundError" in told or "No module named" in told):
        contest.missing[name] = f"not installed: pip install {PEERS[name].package}"
    elif failed:
        contest.missing[name] = told.splitlines()[-1] if told else "its process failed"
    elif late:
        what = "tighter settings were not run" if contest.of(name) else "no answer"
        contest.missing[name] = f"{what} in {LIMIT:g} s"
    elif not contest.of(name):
        contest.missing[name] = "its process ended without an answer"


def hear(lines: Sequence[str], contest: Contest) -> None:
    """What a process said; lines that are not its own, and one cut short, are left out."""
    for line in lines:
        try:
            said = json.loads(line)
        except json.JSONDecodeError:
            continue
        if isinstance(said, dict) and "point" in said:
            contest.points.append(Point(**said["point"]))
        elif isinstance(said, dict):
            contest.versions |= said.get("versions", {})

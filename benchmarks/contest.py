"""Machines against other tools at equal error: every tool in its own process, one after the other.

The speed of the machine varies, and a contest takes a while: before and after each process the
floor of the slider-crank is timed, and factors between contestants are corrected by it. Times are
reported as measured.
"""

import json
import math
import os
import subprocess
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

from benchmarks import linkwright_runs
from benchmarks.precision import Point, best_time, time_to
from benchmarks.problems import IN_SPACE, PROBLEMS, Problem

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
SPACE = tuple(problem.name for problem in IN_SPACE)
PEERS = {
    "exudyn": Peer(
        "exudyn", True, ("slider_crank", "andrews", *LOOPS, "chain_10", "chain_100", *SPACE)
    ),
    "pinocchio": Peer("pin", True, ("slider_crank", "chain_10", *SPACE)),
    "mujoco": Peer("mujoco", True, ("slider_crank", "chain_10", "chain_100", *SPACE)),
    "pydy": Peer("pydy cython", True, ("slider_crank",)),
    "scipy": Peer("scipy sympy", False, ("slider_crank", "andrews")),
    "casadi": Peer("casadi", False, ("slider_crank", "andrews", "chain_10")),
    "numbalsoda": Peer("numbalsoda", False, ("slider_crank", "andrews")),
    "heyoka": Peer("heyoka", False, ("slider_crank", "andrews", "chain_10")),
}


@dataclass
class Contest:
    """The measurements of a problem.

    Attributes
    ----------
    problem
        Its name.
    points
        Of all contestants.
    paces
        Contestant → ms of the slider-crank's floor at the time of its runs.
    versions
        Of the tools.
    missing
        Contestant → reason why points are missing.
    checks
        Further checks, by name.
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
        about = {name: value for name, value in asdict(self).items() if name != "points"}
        rows = []
        for point in self.points:
            error = point.error if math.isfinite(point.error) else None
            rows.append("  " + json.dumps({**asdict(point), "error": error}, ensure_ascii=False))
        head = json.dumps(about, indent=1, ensure_ascii=False)[:-2]
        path.write_text(f'{head},\n "points": [\n' + ",\n".join(rows) + "\n ]\n}\n", "utf-8")


def read(path: Path) -> Contest:
    """A contest that `Contest.write` wrote."""
    found = json.loads(path.read_text(encoding="utf-8"))
    rows = found.pop("points")
    for row in rows:
        row["error"] = math.inf if row["error"] is None else row["error"]
    return Contest(**found, points=[Point(**row) for row in rows])


def run_contest(
    problem: Problem, folder: Path, python: str, before: Contest | None, rounds: int
) -> Contest:
    """Run this program, the floors and the tools, or take the tools from an earlier contest."""
    contest = Contest(problem.name)
    entry = linkwright_runs.ENTRIES[problem.name]
    pace = linkwright_runs.pace()
    contest.points = linkwright_runs.measure(entry, folder, rounds)
    after = linkwright_runs.pace()
    contest.paces = dict.fromkeys((OURS, FLOOR), (pace + after) / 2)
    if problem.name in LOOPS:
        for tolerance in (1e-6, 1e-9):
            apart, energy = linkwright_runs.checked_branch(entry, folder, tolerance)
            contest.checks[f"cranks apart at {tolerance:.0e}"] = apart
            contest.checks[f"energy at {tolerance:.0e}"] = energy
    for name, peer in PEERS.items():
        if problem.name not in peer.problems:
            continue
        if before is not None:
            _carry_over(name, before, contest)
            continue
        pace = linkwright_runs.pace()
        run_peer(name, problem, python, contest)
        contest.paces[name] = (pace + linkwright_runs.pace()) / 2
    return contest


def _carry_over(name: str, before: Contest, contest: Contest) -> None:
    contest.points += before.of(name)
    for old, new in ((before.paces, contest.paces), (before.missing, contest.missing)):
        if name in old:
            new[name] = old[name]  # type: ignore[assignment]  # each from its own table
    contest.versions |= before.versions


def run_peer(name: str, problem: Problem, python: str, contest: Contest) -> None:
    """Run the process of a tool and collect its points."""
    settings = {**os.environ, **dict.fromkeys(THREADS, "1"), "PYTHONPATH": str(ROOT)}
    package = "benchmarks.peers.space" if problem.name in SPACE else "benchmarks.peers"
    command = [python, "-m", f"{package}.{name}", problem.name]
    try:
        done = subprocess.run(
            command, cwd=ROOT, env=settings, capture_output=True, timeout=LIMIT, check=False
        )
        output, errors = done.stdout, done.stderr.decode(errors="replace").strip()
        failed, late = done.returncode != 0, False
    except subprocess.TimeoutExpired as timeout:
        output, errors, failed, late = timeout.stdout or b"", "", False, True
    collect(output.decode(errors="replace").splitlines(), contest)
    if failed and ("ModuleNotFoundError" in errors or "No module named" in errors):
        contest.missing[name] = f"not installed: pip install {PEERS[name].package}"
    elif failed:
        contest.missing[name] = errors.splitlines()[-1] if errors else "its process failed"
    elif late:
        reason = "tighter settings were not run" if contest.of(name) else "no answer"
        contest.missing[name] = f"{reason} in {LIMIT:g} s"
    elif not contest.of(name):
        contest.missing[name] = "its process ended without an answer"


def collect(lines: Sequence[str], contest: Contest) -> None:
    """Points and versions from the output of a process; other and incomplete lines are ignored."""
    for line in lines:
        try:
            entry = json.loads(line)
        except json.JSONDecodeError:
            continue
        if isinstance(entry, dict) and "point" in entry:
            contest.points.append(Point(**entry["point"]))
        elif isinstance(entry, dict):
            contest.versions |= entry.get("versions", {})

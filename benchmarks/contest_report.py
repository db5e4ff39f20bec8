"""A contest as a table, and sentences on its bars."""

import math

from benchmarks.contest import FLOOR, LOOPS, OURS, PEERS, SPACE, TARGETS, Contest
from benchmarks.precision import reliable, series, time_to
from benchmarks.problems import PROBLEMS
from benchmarks.report import Report, verdict

CLOSE = 1e-3
"""Largest angle between a crank and the first on the same branch, rad."""
OVER_FLOOR = {
    "slider_crank": {"reduced": 1.5, "cartesian": 3.0},
    "andrews": {"reduced": 2.0},
    "chain_10": {"reduced": 2.0},
}
HEADINGS = (
    "contestant",
    "method",
    "ms to 1e-6",
    "ms to 1e-9",
    "least error",
    "over the floor",
    "over linkwright",
)


def report(contest: Contest) -> Report:
    """The table of a problem, best first."""
    problem = PROBLEMS[contest.problem]
    rows = []
    for (name, method), points in series(contest.points).items():
        times = [time_to(target, points) for target in TARGETS]
        right = [p.error for p in points if p.right]
        rows.append((times, name, method, min(right, default=math.inf), points))
    rows.sort(key=lambda row: (row[0][0], row[0][1], row[3]))
    cells = [
        (
            name,
            method if right < math.inf else f"{method}: {points[0].note or 'no answer'}",
            *(shown(time) for time in times),
            f"{right:.0e}" if right < math.inf else "none",
            factors(contest, times, name, FLOOR),
            factors(contest, times, name, OURS),
        )
        for times, name, method, right, points in rows
    ]
    cells += [
        (name, reason, "", "", "", "", "")
        for name, reason in contest.missing.items()
        if not contest.of(name)
    ]
    return Report(
        f"peers_{contest.problem}",
        f"{problem.title}: time to an error",
        HEADINGS,
        cells,
        [*bars(contest), *conditions(contest)],
        [
            {"contestant": name, "method": method, "milliseconds": finite(times), "error": right}
            for times, name, method, right, _ in rows
            if right < math.inf
        ],
        2,
    )


def shown(time: float) -> str:
    """Milliseconds, three digits."""
    if not math.isfinite(time):
        return "not reached"
    return f"{time:.3g}" if time < 1000 else f"{time:.0f}"


def finite(times: list[float]) -> dict[str, float | None]:
    """Milliseconds by error; nothing where it is not reached."""
    return {
        f"{target:.0e}": time if math.isfinite(time) else None
        for time, target in zip(times, TARGETS, strict=True)
    }


def fastest(contest: Contest, name: str, target: float) -> float:
    """The best time of a contestant, ms."""
    return contest.least(name, target)[0]


def factors(contest: Contest, times: list[float], name: str, other: str) -> str:
    """At both errors, in times of the best of another, corrected by the pace."""
    share = contest.paces[other] / contest.paces[name] if contest.of(other) else math.nan
    found = []
    for time, target in zip(times, TARGETS, strict=True):
        factor = time * share / fastest(contest, other, target)
        found.append(f"{factor:.3g}" if math.isfinite(factor) else "-")
    return " / ".join(found)


def bars(contest: Contest) -> list[str]:
    """Sentences on this program over the floor, and on the tools over this program."""
    sentences: list[str] = []
    for method, bar in OVER_FLOOR.get(contest.problem, {}).items():
        for target in TARGETS:
            ratio = time_to(target, contest.of(OURS, method)) / time_to(
                target, contest.of(FLOOR, "floor")
            )
            sentences.append(
                verdict(f"{method} to {target:.0e}, in times of the floor:", ratio, bar)
            )
    for name, chosen, target, bar in over_tools(contest.problem):
        method = chosen or contest.least(OURS, target)[1]
        if contest.of(name):
            factor = contest.factor(name, OURS, method, target)
            if math.isinf(factor):
                sentences.append(not_reached(contest, name, method, target))
            else:
                holds = "holds" if factor >= bar else "is missed"
                sentences.append(
                    f"{name} to {target:.0e}, in times of {method}: {factor:.0f}; the bar of "
                    f"{bar:g} {holds}."
                )
    return sentences


def not_reached(contest: Contest, name: str, method: str, target: float) -> str:
    """Sentence on a tool that does not reach an error, with its time to its least error."""
    why = f" ({contest.missing[name]})" if name in contest.missing else ""
    sentence = f"{name} does not reach {target:.0e}{why}; {method} does."
    least = min(
        (error for line in series(contest.of(name)).values() for error, _ in reliable(line)),
        default=math.inf,
    )
    factor = contest.factor(name, OURS, method, least) if math.isfinite(least) else math.inf
    if math.isfinite(factor):
        sentence += f" To {least:.0e}, its least error, it takes {factor:.0f} times as long."
    return sentence


def over_tools(problem: str) -> list[tuple[str, str, float, float]]:
    """(tool, method of ours or "" for the faster, error, how many times longer it must take)."""
    if problem == "slider_crank":
        return [
            (name, method, 1e-9, bar)
            for name in ("pydy", "pinocchio")
            for method, bar in (("reduced", 100.0), ("cartesian", 50.0))
        ]
    if problem == "andrews":
        return [("exudyn", "reduced", 1e-6, 1000.0)]
    if problem in LOOPS:
        return [("exudyn", "cartesian", 1e-6, 100.0)]
    if problem in SPACE:
        peers = [name for name, peer in PEERS.items() if problem in peer.problems]
        return [(name, "", target, 50.0) for name in peers for target in TARGETS]
    multibody = [name for name, peer in PEERS.items() if peer.multibody]
    return [(n, "reduced", 1e-9, 1.0) for n in multibody if problem in PEERS[n].problems]


def conditions(contest: Contest) -> list[str]:
    """Further checks, and the pace of the machine."""
    sentences: list[str] = []
    for what, value in contest.checks.items():
        if what.startswith("cranks"):
            side = "the right branch throughout" if value < CLOSE else "another branch"
            sentences.append(f"{what}: {value:.1e} rad, {side}.")
        else:
            sentences.append(f"error of the {what}: {value:.1e} of its range.")
    sentences += [
        f"{name} has not all its points: {reason}."
        for name, reason in contest.missing.items()
        if contest.of(name)
    ]
    paces = ", ".join(f"{name} {pace:.2f}" for name, pace in contest.paces.items())
    sentences.append(f"Pace, ms of the slider-crank's floor at 1e-9 about each run: {paces}.")
    tools = ", ".join(f"{name} {version}" for name, version in contest.versions.items())
    if tools:
        sentences.append(f"Tools: {tools}.")
    return sentences

"""Comparison of two scenes of a machine, part by part."""

from dataclasses import dataclass

from codegen.explain.ledger_data import Ledger, Part


@dataclass(frozen=True)
class Row:
    """A part in both scenes; a side is None where the scene's ledger does not know it.

    Attributes
    ----------
    acts
        Whether it is in.
    accelerations, operations
        Operations of the kernel `accelerations`, and of all kernels.
    nanoseconds
        Of an evaluation of `accelerations`, where it was measured.
    """

    name: str
    acts: tuple[bool | None, bool | None]
    accelerations: tuple[int, int]
    operations: tuple[int, int]
    nanoseconds: tuple[float | None, float | None]


@dataclass(frozen=True)
class Comparison:
    """Two ledgers side by side; `total` has no `acts`."""

    first: Ledger
    second: Ledger
    rows: tuple[Row, ...]
    total: Row


def compare(first: Ledger, second: Ledger) -> Comparison:
    """The parts of two ledgers in the order of declaration, shared work last."""
    sides = [{part.name: part for part in ledger.parts} for ledger in (first, second)]
    names = [name for name, part in sides[0].items() if part.role != "shared"]
    names += [name for name, part in sides[1].items() if part.role != "shared"]
    names += [name for side in sides for name, part in side.items() if part.role == "shared"]
    rows = tuple(
        _row(name, sides[0].get(name), sides[1].get(name)) for name in dict.fromkeys(names)
    )
    total = Row(
        "total",
        (None, None),
        (first.totals.get("accelerations", 0), second.totals.get("accelerations", 0)),
        (sum(first.totals.values()), sum(second.totals.values())),
        (_whole(first), _whole(second)),
    )
    return Comparison(first, second, rows, total)


def _row(name: str, one: Part | None, other: Part | None) -> Row:
    pair = (one, other)
    acts, time = ([getattr(p, key, None) for p in pair] for key in ("acts", "nanoseconds"))
    solving = [p.operations.get("accelerations", 0) if p else 0 for p in pair]
    every = [sum(p.operations.values()) if p else 0 for p in pair]
    return Row(
        name,
        (acts[0], acts[1]),
        (solving[0], solving[1]),
        (every[0], every[1]),
        (time[0], time[1]),
    )


def _whole(ledger: Ledger) -> float | None:
    if ledger.nanoseconds is None:
        return None
    return sum(part.nanoseconds or 0.0 for part in ledger.parts)

"""Comparison of two scenes of a machine, part by part."""

from dataclasses import dataclass, replace

from codegen.explain.ledger_records import Ledger, Part


@dataclass(frozen=True)
class Row:
    """A part in both scenes."""

    name: str
    acts: tuple[bool | None, bool | None]  # whether it is in; None: unknown to the scene's ledger
    accelerations: tuple[int, int]  # operations of the kernel `accelerations`
    operations: tuple[int, int]  # of all kernels
    nanoseconds: tuple[float | None, float | None]  # of an evaluation of `accelerations`


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
    names = [
        name
        for shared in (False, True)
        for side in sides
        for name, part in side.items()
        if (part.role == "shared") is shared
    ]
    rows = tuple(_row(name, *(side.get(name) for side in sides)) for name in dict.fromkeys(names))
    whole = (_whole(ledger) for ledger in (first, second))
    return Comparison(first, second, rows, replace(_row("total", *whole), acts=(None, None)))


def _whole(ledger: Ledger) -> Part:
    """All parts as one."""
    time = None if ledger.nanoseconds is None else ledger.parts_nanoseconds
    return Part("total", "", "", True, "", ledger.totals, nanoseconds=time)


def _row(name: str, one: Part | None, other: Part | None) -> Row:
    absent = Part(name, "", "", False, "")
    a, b = one or absent, other or absent
    return Row(
        name,
        (one.acts if one else None, other.acts if other else None),
        (a.solving, b.solving),
        (a.total, b.total),
        (a.nanoseconds, b.nanoseconds),
    )

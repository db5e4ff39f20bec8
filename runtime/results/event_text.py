"""Events in words: those of results, of pages and of reports."""

import re

from codegen.readers.values import label_sides
from runtime.core.kinds import Direction
from runtime.mechanism.table_rows import NEXT_PIECE

_LONGEST = 50  # layout: characters of a condition in a text
_COMPARISON = re.compile(r"(\S+) ([<>])=? (\S+)")
_PART = re.compile(r"(.+) \(part: (.+)\)")  # of a condition with a label
_UNITS = {
    **dict.fromkeys("xyz", "m"), "phi": "rad", **dict.fromkeys(("vx", "vy", "vz"), "m/s"),
    **dict.fromkeys(("omega", "omega_x", "omega_y", "omega_z"), "rad/s"), "t": "s",
}  # fmt: skip
_QUANTITY = re.compile(rf"(?:(\w+?)_)?({'|'.join(_UNITS)})")


def event_text(name: str, direction: int) -> str:
    """What happened: `gas: x of slider passes 5 m`, or the words of its label.

    The event's name is `effect: condition`, or `singular: drivers and joints`.
    """
    element, _, condition = name.partition(": ")
    if part := _PART.fullmatch(condition):
        whole, _ = label_sides(part[1])
        return f"{event_text(f'{element}: {part[2]}', direction)} (part of {whole})"
    match Direction(direction):
        case Direction.CROSSED:
            return f"{condition}: a singular position is crossed"
        case Direction.LOCKED:
            return f"{condition}: the machine locks up"
        case Direction.BEGAN | Direction.CEASED:
            begins = direction == Direction.BEGAN
            return _in_words(element, condition, begins) or f"{element}: {_cut(condition)} " + (
                "begins to hold" if begins else "ceases to hold"
            )
        case Direction.HOLDS:
            where = f"the boundary of {_cut(label_sides(condition)[0])}"
            if compared := _compared(condition):
                where = f"{compared[0]} = {compared[2]}"
            return f"{element}: the motion stays on {where}"
    return f"{element}: {_cut(condition)}, impact"


def _in_words(element: str, condition: str, begins: bool) -> str:
    """A comparison, or a label; empty for any other condition."""
    if compared := _compared(condition):
        quantity, rises, bound = compared
        up = rises == begins
        if re.fullmatch(r"0 (m|rad)/s", bound):
            return f"{element}: {quantity} becomes {'positive' if up else 'negative'}"
        return f"{element}: {quantity} {'passes' if up else 'falls below'} {bound}"
    if condition == NEXT_PIECE:
        return f"{element}: {condition}"
    return "" if re.match("(?!.* / ).*[<>]", condition) else label_sides(condition)[not begins]


def _compared(condition: str) -> tuple[str, bool, str] | None:
    """Quantity, whether it is above its bound where the condition holds, and the bound."""
    if (found := _COMPARISON.fullmatch(condition)) is None:
        return None
    left, sign, right = found.groups()
    above = sign == ">"
    if (known := _QUANTITY.fullmatch(left)) is None:
        left, right, above = right, left, not above
        known = _QUANTITY.fullmatch(left)
    if known is None or (known[1] is None) != (known[2] == "t"):
        return None
    quantity = f"{known[2]} of {known[1]}" if known[1] else "t"
    try:
        return quantity, above, f"{float(right):.6g} {_UNITS[known[2]]}"
    except ValueError:
        return quantity, above, right


def _cut(condition: str) -> str:
    return condition[:_LONGEST] + " …" if len(condition) > _LONGEST else condition

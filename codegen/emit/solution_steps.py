"""Names of the values of a solution, and the step of the solution that each belongs to.

The factorization labels what it computes: entries of the reduced matrix, pivots, right sides,
unknowns. A value without a label belongs to the first step that needs it.
"""

from codegen.lower.program import LEAVES, Kernel, Op, Program

BESIDE_ELEMENTS = {
    "factorization": "Factorization of M, Φ_q",
    "correction": "Factorization of Φ_q W Φ_qᵀ",
    "masses": "Masses",
    "reduction": "Coordinates by those that are left",
    "": "Sums",
}
"""The heading of values that serve no element; the others are called after their element."""

PREFIXES = {"factorization": "f", "correction": "c", "masses": "m", "reduction": "r", "": "s"}
"""The beginning of the names of values that serve no element, such as ``f_1``."""

LONGEST = 36  # characters of a name; values with longer ones are numbered


def names_of_solution(program: Program, kernel: Kernel, numbers: tuple[int, ...]) -> dict[int, str]:
    """Value → its name, among the `numbers` that a kernel needs and that bear no element's name."""
    names: dict[int, str] = {}
    values = program.values
    named = [(label.value, label.name) for label in kernel.labels]
    negative = [(k, name) for k, name in named if values[k].op is Op.NEG]
    named += [(values[k].args[0], f"minus_{name}") for k, name in negative]  # signs are outside
    names = {number: name for number, name in reversed(named) if _has_label(program, number)}
    return {k: names[k] for k in numbers if k in names and len(names[k]) <= LONGEST}


def _has_label(program: Program, number: int) -> bool:
    value = program.values[number]
    named = value.op in LEAVES or value.op in (Op.SIN, Op.COS)
    return not named and value.serves in BESIDE_ELEMENTS


def order_by_steps(
    program: Program, kernel: Kernel, hoisted: frozenset[int]
) -> tuple[tuple[int, ...], dict[int, int]]:
    """The values that a kernel needs, step by step, and the step of each value of a solution.

    Values are numbered as they were first asked for, perhaps by another kernel or by an order of
    elimination that was given up; a reader wants those of one step together.
    """
    numbers = program.reachable(kernel)
    if not kernel.steps:
        return numbers, {}
    last = len(kernel.steps) - 1
    own: dict[int, int] = {}
    for label in kernel.labels:
        value = program.values[label.value]
        own.setdefault(label.value, label.step)
        if value.op is Op.NEG:
            own.setdefault(value.args[0], label.step)
    found: dict[int, int] = {}
    for number in reversed(numbers):
        found[number] = min(own.get(number, last), found.get(number, last))
        if number not in hoisted:
            for a in program.values[number].args:
                found[a] = min(found.get(a, last), found[number])
    steps = {number: step for number, step in found.items() if _has_label(program, number)}
    place: dict[int, int] = {}
    for number in numbers:
        args = () if number in hoisted else program.values[number].args
        place[number] = steps.get(number, max((place[a] for a in args), default=-1))
    return tuple(sorted(numbers, key=lambda number: (place[number], number))), steps

"""An order of evaluation in which values are computed where they are first taken.

The values of a program stand in the order in which they were derived: all sines, then all terms of
the constraints, then the elimination. A loop over the bars for each of these would pass everything
that a bar computes through memory. A depth-first search from what the kernel stores brings together
what belongs together: a bar's terms, its elimination, then the next bar.
"""

from collections.abc import Container, Sequence

from codegen.lower.program import Kernel, Op, Value


def order_on_demand(
    values: Sequence[Value], kernel: Kernel, constants: Container[int]
) -> list[int]:
    """Numbers of the values that `kernel` computes, each right before the first that takes it.

    The opposite of a value that is stored or checked stands behind the value, and a pivot's
    reference behind the pivot: neither waits in memory. `constants` are read and not computed.
    """
    behind: dict[int, list[int]] = {}
    for root in dict.fromkeys(kernel.roots):
        if values[root].op is Op.NEG:
            behind.setdefault(values[root].args[0], []).append(root)
    for check in kernel.checks:
        behind.setdefault(check.pivot, []).append(check.reference)
    visited, found = bytearray(len(values)), list[int]()
    stack = [*reversed(kernel.roots)]
    while stack:
        number = stack.pop()
        if number < 0:  # all that it takes is there
            number = ~number
            found.append(number)
            if number in behind:
                stack += reversed(behind[number])
        elif not visited[number]:
            visited[number] = True
            args = values[number].args
            if args and number not in constants:
                stack.append(~number)
                stack += args[::-1]
    return found

"""A value written out as one formula, for people."""

from codegen.lower.program import Input, Lookup, Op, Program

SIGNS = {Op.ADD: "+", Op.SUB: "-", Op.MUL: "*", Op.DIV: "/"}
LEVEL = {Op.ADD: 1, Op.SUB: 1, Op.NEG: 1, Op.MUL: 2, Op.DIV: 2}


def formula(program: Program, number: int) -> str:
    """The whole expression behind a value, in the modeller's names."""
    value = program.values[number]
    if value.op is Op.CONST:
        return f"{value.literal:g}"
    if isinstance(value.literal, Input):
        return value.literal.name
    if value.op is Op.NEG:
        return f"-{_inside(program, value.args[0], 2)}"
    if value.op in SIGNS:
        level = LEVEL[value.op]
        left = _inside(program, value.args[0], level)
        right = _inside(program, value.args[1], level + (value.op in (Op.SUB, Op.DIV)))
        return f"{left} {SIGNS[value.op]} {right}"
    name = value.literal.table.name if isinstance(value.literal, Lookup) else value.op.value
    return f"{name}({', '.join(formula(program, a) for a in value.args)})"


def _inside(program: Program, number: int, level: int) -> str:
    text = formula(program, number)
    return f"({text})" if LEVEL.get(program.values[number].op, 3) < level else text

"""Write docs/reference/constants.md, the table of every constant that tunes the numerics.

Usage: ``python docs/make_constants.py [--check]``. With ``--check`` nothing is written; the exit
status is 1 where the page is stale or a constant has no kind.

A tuning constant is a number that a module of `codegen` or `runtime` gives a name in capitals. It
carries a kind and a reason, as ``_RETAKES = 5  # safety: ...``, in the comment on its line, in the
comment above it, or in the docstring below it. The kinds are

- ``safety``: bounds a loop, or guards a division or a search;
- ``accuracy``: a tolerance, decides digits;
- ``measured``: chosen by experiment on the library's machines.

A kind may stay away where nothing is tuned:

- public integers: rows, slots, codes and orders, which other modules share;
- `EPS`, multiples of π, and names that count 0, 1, 2, … in one assignment;
- lines that say ``layout:``, ``code:`` or ``formula:`` in place of a kind, and every line of a
  group, up to the next empty one, below a comment that begins so;
- members of classes, enumerations among them.

Outside the rooms in `DEMANDED` no kind is asked for, but those that are there are listed.
"""

import argparse
import ast
import re
import sys
import tokenize
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "reference" / "constants.md"

DEMANDED = (
    "codegen",
    *(
        f"runtime/{room}"
        for room in (
            "assembly",
            "constraints",
            "continuation",
            "core",
            "dynamics",
            "hybrid",
            "integrate",
            "linalg",
            "mechanism",
            "singularity",
            "statics",
        )
    ),
)

KINDS = ("safety", "accuracy", "measured")
NO_TUNING = ("layout", "code", "formula")
KIND = re.compile(rf"({'|'.join(KINDS + NO_TUNING)}):\s*(.*)", re.DOTALL | re.IGNORECASE)
NAME = re.compile(r"_?[A-Z][A-Z0-9_]*$")

HEAD = """# Constants

Every number that tunes the numerics, with its kind and its reason. `docs/make_constants.py` makes
the page from the source, and `make check` compares them. The kinds are

- **safety**: bounds a loop, or guards a division or a search; a result does not depend on it;
- **accuracy**: a tolerance; it decides how many digits a result has;
- **measured**: chosen by experiment on the library's machines; it decides how long a run takes.

A reason that begins with *of* completes the value: `1e-9` *of a size* is 1e-9 times this size.
`EPS` is the unit roundoff of double precision, 2⁻⁵². The coefficients of integration methods tune
nothing and are left out.

"""


@dataclass(frozen=True)
class Constant:
    """A number with a name, and what its module says of it."""

    module: str
    line: int
    name: str
    value: str
    kind: str
    reason: str


def is_number(node: ast.expr) -> bool:
    """Whether an expression is a number, arithmetic of numbers, or a tuple of them."""
    match node:
        case ast.Constant(value=value):
            return isinstance(value, (int, float)) and not isinstance(value, bool)
        case ast.UnaryOp(operand=operand):
            return is_number(operand)
        case ast.BinOp(left=left, right=right):
            return is_number(left) and is_number(right)
        case ast.Tuple(elts=elements):
            return bool(elements) and all(is_number(e) for e in elements)
        case ast.Call(func=ast.Attribute(attr="sqrt") | ast.Name(id="sqrt"), args=[argument]):
            return is_number(argument)
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return bool(NAME.match(name)) or name == "pi"
        case _:
            return False


def has_literal(node: ast.expr) -> bool:
    """Whether a number is written out in an expression."""
    return any(isinstance(n, ast.Constant) for n in ast.walk(node))


def needs_no_kind(name: str, node: ast.expr) -> bool:
    """Whether a constant is no tuning constant unless it says so."""
    parts = list(ast.walk(node))
    if any(isinstance(n, ast.Attribute) and n.attr == "pi" for n in parts):
        return True
    written = [n.value for n in parts if isinstance(n, ast.Constant)]
    names = [n for n in parts if isinstance(n, (ast.Name, ast.Attribute))]
    whole = all(isinstance(value, int) for value in written)
    divides = any(isinstance(n, ast.Div) for n in parts)
    of_floats = any(getattr(n, "id", "") == "EPS" for n in names)
    return whole and not divides and not of_floats and not name.startswith("_")


def comments(text: str) -> dict[int, tuple[int, str]]:
    """Line → column and text of its comment."""
    tokens = tokenize.generate_tokens(iter(text.splitlines(keepends=True)).__next__)
    return {
        t.start[0]: (t.start[1], t.string.lstrip("# "))
        for t in tokens
        if t.type == tokenize.COMMENT
    }


def above(line: int, remarks: dict[int, tuple[int, str]]) -> str:
    """The comment that ends on the line before `line`, if it stands alone."""
    block: list[str] = []
    while (line := line - 1) in remarks and remarks[line][0] == 0:
        block.insert(0, remarks[line][1])
    return " ".join(block)


def heading(line: int, lines: list[str], remarks: dict[int, tuple[int, str]]) -> str:
    """The comment at the head of the group of lines that `line` belongs to."""
    while line > 1 and lines[line - 2].strip():
        line -= 1
    return remarks[line][1] if line in remarks and remarks[line][0] == 0 else ""


def read(path: Path) -> list[Constant]:
    """The constants of one module that tune something; the kind is empty where none is said."""
    text = path.read_text(encoding="utf-8")
    body = ast.parse(text).body
    remarks = comments(text)
    lines = text.splitlines()
    module = path.relative_to(ROOT).as_posix()
    found = []
    for node, following in zip(body, [*body[1:], None], strict=True):
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                pairs = [(name, value)]
            case ast.Assign(targets=[ast.Tuple(elts=names)], value=ast.Tuple(elts=values)):
                both = zip(names, values, strict=True)
                pairs = [(n.id, v) for n, v in both if isinstance(n, ast.Name)]
            case ast.AnnAssign(target=ast.Name(id=name), value=ast.expr() as value):
                pairs = [(name, value)]
            case _:
                continue
        pairs = [(name, value) for name, value in pairs if NAME.match(name) and has_literal(value)]
        numbers = [v.value for _, v in pairs if isinstance(v, ast.Constant)]
        counted = len(pairs) > 1 and numbers == list(range(len(pairs)))
        if not pairs or counted or pairs[0][0] == "EPS":
            continue
        said = [
            remarks.get(node.end_lineno or node.lineno, (0, ""))[1],
            above(node.lineno, remarks),
        ]
        match following:
            case ast.Expr(value=ast.Constant(value=str(docstring))):
                said.append(docstring)
        said.append(heading(node.lineno, lines, remarks))
        match = next((m for m in map(KIND.match, said) if m), None)
        kind = match[1].lower() if match else ""
        reason = " ".join(match[2].split()) if match else ""
        if kind in NO_TUNING:
            continue
        for name, value in pairs:
            if not kind and (not is_number(value) or needs_no_kind(name, value)):
                continue
            written = " ".join((ast.get_source_segment(text, value) or "").split())
            found.append(Constant(module, node.lineno, name, written, kind, reason))
    return found


def all_constants() -> list[Constant]:
    """The constants of all modules, by path and line."""
    files = [
        p
        for room in ("codegen", "generated/methods", "runtime")
        for p in (ROOT / room).rglob("*.py")
    ]
    return [constant for path in sorted(files) for constant in read(path)]


def without_kind(constants: list[Constant]) -> list[str]:
    """A sentence for each constant that needs a kind and has none, or has no reason."""
    return [
        f"{c.module}:{c.line}: {c.name} = {c.value} has no {'reason' if c.kind else 'kind'}; "
        f"write `# {c.kind or '|'.join(KINDS)}: reason` on its line"
        for c in constants
        if not (c.kind and c.reason) and c.module.startswith(DEMANDED)
    ]


def page(constants: list[Constant]) -> str:
    """The text of docs/reference/constants.md."""
    parts = [HEAD]
    kinds = {kind: sum(c.kind == kind for c in constants) for kind in KINDS}
    parts.append(", ".join(f"{count} {kind}" for kind, count in kinds.items()) + ".\n")
    told = [c for c in constants if c.kind]
    for module, group in groupby(told, key=lambda c: c.module):
        parts.append(
            f"\n## `{module}`\n\n| constant | value | kind | reason |\n|---|---|---|---|\n"
        )
        for c in group:
            reason = c.reason.replace("|", r"\|")
            parts.append(f"| `{c.name}` | `{c.value}` | {c.kind} | {reason} |\n")
    return "".join(parts)


def main(arguments: list[str]) -> int:
    """Write the page, or compare it; say on stderr which constants have no kind."""
    parser = argparse.ArgumentParser(
        description="Write docs/reference/constants.md from the source."
    )
    parser.add_argument("--check", action="store_true", help="write nothing; compare")
    check: bool = parser.parse_args(arguments).check
    constants = all_constants()
    problems = without_kind(constants)
    text = page(constants)
    if check and (not PAGE.exists() or PAGE.read_text(encoding="utf-8") != text):
        problems.append("docs/reference/constants.md is stale; run `python docs/make_constants.py`")
    if not check:
        PAGE.write_text(text, encoding="utf-8")
    for problem in problems:
        print(problem, file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

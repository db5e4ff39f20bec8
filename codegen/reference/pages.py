"""Pages of the reference: a kind with an example, its equations, reaction and cost; the index.

Each kind of the library has a small sound model, its example: the element between two free bodies.
The pages show these declarations, their equations and their costs, and the tests hold every kind
to the same laws with them. The lines stand in the element's class, as `example`, exactly as a page
shows them; they may use the bodies and points of `Pair`. The last call is of the method of `Model`
that declares the kind; where several do, `declared_by` of the class names them.
"""

import inspect
import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import sympy

from codegen.declare.element import Constraint, Effect
from codegen.declare.symbols import alpha, t
from codegen.derive.equations import Equations, derive
from codegen.elements.registry import Kind, kinds_of_elements
from codegen.errors import ModelError
from codegen.generated_files.generated_file import Written, write_folder
from codegen.lower.lowered_scene import lower
from codegen.lower.operation_count import by_element
from codegen.model import Model
from codegen.readers.values import nearest, shown
from codegen.reading.scene_selection import valid_scenes
from codegen.reference.equations import constraint_sections, effect_sections
from codegen.reference.vector_equations import block


class Pair(Model):
    """Two free bodies `i` and `j` with a point each, `P` on i and `Q` on j, named by parameters."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.i = self.body("i", mass=2.0, inertia=0.5)
        self.j = self.body("j", mass=3.0, inertia=0.7)
        places = {"i_sx": 0.3, "i_sy": -0.2, "j_sx": -0.5, "j_sy": 0.4}
        s = [self.parameter(place, value, unit="m") for place, value in places.items()]
        self.P, self.Q = self.i.at(*s[:2]), self.j.at(*s[2:])


@dataclass(frozen=True)
class Example:
    """An element in a model."""

    model: Model
    element: Constraint | Effect  # the one element that is looked at
    methods: tuple[str, ...] = ()  # methods of `Model` that declare the kind; none for one's own
    source: str = ""  # the lines that declare it; empty where they are in a file of their own


def example_of(kind: str, model: Model | None = None) -> Example:
    """The library's example of a kind, or the first in `model`; ModelError if there is none."""
    registered = kinds_of_elements()
    if kind not in registered:
        raise ModelError(f"there is no element {shown(kind)}; {nearest(kind, registered)}")
    if model is not None:
        for element in _elements(model):
            if element.kind == kind:
                return Example(model, element)
    cls = registered[kind].element
    if registered[kind].is_user_defined:
        raise ModelError(
            f"element '{kind}' is one of your own, of {cls.__module__}; name a model file that "
            "declares one: linkwright elements --model FILE."
        )
    source = textwrap.dedent(getattr(cls, "example", "")).strip()
    if not source:
        raise ModelError(
            f"the library's element '{kind}' has no example; add one to {cls.__qualname__} of "
            f"{cls.__module__}."
        )
    pair = Pair("example")
    names = {"model": pair, "alpha": alpha, "t": t, "i": pair.i, "j": pair.j}
    names |= {"P": pair.P, "Q": pair.Q, "sin": sympy.sin, "cos": sympy.cos, "pi": sympy.pi}
    exec(source, names)
    (element,) = (e for e in _elements(pair) if e.kind == kind)
    *_, method = re.findall(r"model\.(\w+)", source)
    return Example(pair, element, getattr(cls, "declared_by", (method,)), source)


def _elements(model: Model) -> Iterator[Constraint | Effect]:
    yield from model.joints.values()
    yield from model.drivers.values()
    yield from model.effects.values()


COUNTED = (
    *("constants", "constraints", "jacobian", "velocity_rhs", "acceleration_rhs"),
    *("potential", "potential_gradient", "applied_forces", "accelerations"),
    *("correction", "reactions", "powers", "switching", "switching_rates"),
    *("gap_accelerations", "switched_reactions"),
)
"""Kernels in the order in which a page lists them."""

UNDERLINE = re.compile(r"-{3,}\s*")
LISTS = ("Attributes", "Parameters", "Raises", "Returns")
"""Sections of a docstring in numpy's form, by the line below a heading, and lists among them."""

COST = """## Cost

How many operations the element adds to each kernel of the example; equal ones count once:

| kernel | operations |
|---|--:|"""
INDEX, SPACE = "index.md", "in-space.md"
IN_SPACE = """# Elements of machines in space

Kinds of `Model(name, space=True)` whose equations are not those of the plane. r_i^P is the point \
of body i, d the way from it to that of body j; f, g and h are unit vectors of a body, \
perpendicular to each other, h along the axis of the joint. A is the rotation matrix of a body, \
Q_r the force on it; s' is the place of its point, n' the torque, in its axes.

The entries of Φ_q are columns, those by turns δπ about global axes; in the axes of the body \
Φ_π' = Φ_π A, and by Euler parameters Φ_p = 2 Φ_π E with E = [-e, ẽ + e0 I]. s_i and s_j lead from \
the centres of mass to the points. Without accelerations ḟ = ω × f and f̈ = ω × (ω × f) for a \
vector of a body, ḋ = ṙ_j + ṡ_j - ṙ_i - ṡ_i and d̈ = s̈_j - s̈_i. θ is an angle that a joint counts."""
ABOUT = """# Elements

The joints, drivers and forces of the library. Each page shows the equations of an element as they \
are compiled, and their cost in operations. In them i and j are the two bodies of an element, with \
the coordinates x, y, φ; s'_i is a point in the frame of body i, s_i = A_i s'_i the same vector in \
global axes, and d the way from the point of i to that of j."""
WRITTEN = "*Written by `python -m codegen elements --out docs/elements`.*"
ROLES = {"joint": "Joints", "driver": "Drivers", "force": "Forces"}


def slug(kind: str) -> str:
    """The name of a kind's file, without its ending: ``cam-and-follower``."""
    return "-".join(kind.lower().replace("_", " ").split())


def find_kind(name: str) -> str:
    """The kind of that name, with spaces, hyphens or underscores; ModelError if there is none."""
    known = kinds_of_elements() | kinds_of_elements(space=True)
    for kind in known:
        if slug(name) == slug(kind):
            return kind
    raise ModelError(f"there is no element {shown(name)}; {nearest(name, known)}")


def chosen_kinds(
    model: Model | None = None, only: str | None = None, *, space: bool = False
) -> dict[str, Kind]:
    """The kinds of the plane or of space: the library's, a user's with an example in `model`."""
    elements = () if model is None else (*model.joints.values(), *model.effects.values())
    in_model = {element.kind for element in elements}
    return {
        name: kind
        for name, kind in kinds_of_elements(space=space).items()
        if only in (None, name) and (not kind.is_user_defined or name in in_model or only == name)
    }


def write(
    folder: Path, model: Model | None = None, only: str | None = None, *, check: bool = False
) -> Written:
    """Write the pages of all kinds and their index, or the page of one kind; as `write_folder`.

    `model` has elements of one's own, `only` is one kind, without the index. Raises InputError if a
    kind has no sound example, or the folder cannot be written.
    """
    kinds = chosen_kinds(model, only)
    texts = {f"{slug(name)}.md": page(name, model) for name in kinds}
    if only is not None:
        return write_folder(folder, texts, check=check)
    texts |= {INDEX: index(kinds), SPACE: space_page()}
    return write_folder(folder, texts, others="*.md", check=check)


def index(kinds: dict[str, Kind]) -> str:
    """The list of the kinds, role by role."""
    sections = []
    for role, heading in ROLES.items():
        chosen = (kind for kind in kinds.values() if kind.role == role)
        rows = (f"- [{kind.name}]({slug(kind.name)}.md): {kind.summary}" for kind in chosen)
        sections.append("\n".join((f"## {heading}", "", *rows)))
    sections.append(f"## In space\n\n- [Elements of machines in space]({SPACE})")
    return "\n\n".join((ABOUT, *sections, WRITTEN)) + "\n"


def space_page() -> str:
    """The library's kinds in space, role by role: docstrings, and equations in vectors."""
    known = chosen_kinds(space=True).values()
    sections = [IN_SPACE]
    for role, heading in ROLES.items():
        chosen = (kind for kind in known if kind.role == role)
        sections.append(f"## {heading}")
        for kind in chosen:
            sections += [f"### {kind.name.removesuffix(' in space')}", *_in_space(kind)]
    return "\n\n".join((*sections, WRITTEN)) + "\n"


def _in_space(kind: Kind) -> Iterator[str]:
    """The docstring of a kind in space, and its equations in vectors."""
    yield kind.text
    if hasattr(kind.element, "phi"):
        yield block(kind.element.phi)


def page(kind: str, model: Model | None = None) -> str:
    """The reference page of a kind, Markdown with LaTeX between dollars.

    A kind is one of `kinds_of_elements`; the library's have examples, others need a `model` with an
    element of it. Kinds in space have their section of `space_page`. Raises ModelError if there is
    no such kind, no example of it, or the example is not sound.
    """
    if in_space := kinds_of_elements(space=True).get(kind):
        return "\n\n".join((f"# {kind.capitalize()}", *_in_space(in_space))) + "\n"
    example = example_of(kind, model)
    registered = kinds_of_elements()[kind]
    sections = (
        f"# {kind.capitalize()}",
        markdown(registered.element.__doc__),
        *_declaration(registered, example),
        *_compiled(example),
        f"*Written by `python -m codegen elements` from `{registered.element.__module__}`.*"
        if not registered.is_user_defined
        else "*Written by `python -m codegen elements`.*",
    )
    return "\n\n".join(sections) + "\n"


def _declaration(kind: Kind, example: Example) -> Iterator[str]:
    yield "## Declaration"
    for name in example.methods:
        method = getattr(Model, name)
        yield f"```python\nmodel.{name}{_arguments(method, drop=1)}\n```"
        yield markdown(method.__doc__)
    if not example.methods:
        declaration = f"{kind.element.__name__}{_arguments(kind.element, drop=0)}"
        yield f"```python\nmodel.add({declaration})\n```"
    if example.source:
        yield (
            f"An example, between two free bodies `i` and `j` with the points `P` on i and `Q` on "
            f"j:\n\n```python\n{example.source}\n```"
        )


def _arguments(function: object, drop: int) -> str:
    assert callable(function)
    signature = inspect.signature(function)
    bare = [
        parameter.replace(annotation=parameter.empty)
        for parameter in list(signature.parameters.values())[drop:]
    ]
    shown = str(signature.replace(parameters=bare, return_annotation=signature.empty))
    return shown.replace("'", '"')


def _compiled(example: Example) -> Iterator[str]:
    element, equations = example.element, _equations(example)
    if isinstance(element, Constraint):
        yield from constraint_sections(element)
    else:
        yield from effect_sections(equations, element)
    program = lower(equations).program
    counts = {kernel.name: by_element(program, kernel)[element.name] for kernel in program.kernels}
    rows = [f"| `{name}` | {counts[name]} |" for name in COUNTED if counts.get(name)]
    if rows:
        yield "\n".join((COST, *rows))


def _equations(example: Example) -> Equations:
    """Those of the first scene that the element takes part in."""
    model, element = example.model, example.element
    for scene in valid_scenes(model, None):
        equations = derive(model, scene)
        names = [*(c.name for c in equations.constraints), *(e.name for e in equations.effects)]
        if element.name in names:
            return equations
    raise ModelError(
        f"no scene of model '{model.name}' has {element.kind} '{element.name}' in it; name it "
        "in one."
    )


def markdown(docstring: str | None) -> str:
    """A docstring in numpy's form as Markdown: headings of sections in bold, entries as lists."""
    lines = inspect.cleandoc(docstring or "").splitlines()
    shown: list[str] = []
    listing = False
    for k, line in enumerate(lines):
        if UNDERLINE.fullmatch(line):
            listing = lines[k - 1] in LISTS
        elif k + 1 < len(lines) and UNDERLINE.fullmatch(lines[k + 1]):
            shown += [f"**{line}**", ""]
        elif listing and line and not line.startswith(" "):
            names = ", ".join(f"`{name.strip()}`" for name in line.split(","))
            shown.append(f"- {names}:")
        elif listing and line:
            shown.append(f"  {line.strip()}")
        else:
            shown.append(line)
    return "\n".join(shown).strip()

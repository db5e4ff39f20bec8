"""The equations of an element as sections of its page, and how its reaction is reported."""

from collections.abc import Iterator
from itertools import chain

import sympy

from codegen.declare.element import Constraint, Effect, J, JointReaction, Statement
from codegen.declare.symbols import KINDS, Coordinate, Given, given, kinds
from codegen.derive.constraint_terms import ConstraintTerms, constraint_terms
from codegen.derive.effect_terms import FrictionTerms
from codegen.derive.equations import Equations
from codegen.latex import FRAMED, Abbreviations, aligned, latex, lettered

NUMBERS = ("No", "One", "Two", "Three", "Four", "Five", "Six")

HELD = {
    "friction": (
        "In mode 1 {g} is positive and σ is 1; in mode 0 {g} is negative and σ is -1. Where "
        "both sides push onto {g} = 0 the motion stays there, with σ between -1 and 1."
    ),
    "contact": (
        "In mode 1 {g} is positive and σ is 0; in mode 0 σ is 1. While the contact is closed, "
        "{g} = 0, a run finds the σ, from 0 to infinity, that keeps {g} at 0."
    ),
    "clutch": (
        "In mode 1 {g} is positive and σ is 0; in mode 0 σ is 1. While the clutch grips, "
        "{g} = 0, a run finds the σ, from 0 to infinity, that keeps {g} at 0."
    ),
}
"""The meaning of the symbol of a friction, contact or freewheel."""

SIZE = r"\left|\sigma\right|_{\max}"

Pairs = list[tuple[str, sympy.Expr]]


def constraint_sections(element: Constraint) -> Iterator[str]:
    """Φ, Φ_q, ν and γ, and the reaction, of a joint or driver."""
    statement, terms = constraint_terms(element)
    reactions = [e for _, _, e in terms.reactions]
    reaction = statement.reaction
    axis = tuple(reaction.direction) if isinstance(reaction, JointReaction) else ()
    rows = (*terms.jacobian, terms.nu, terms.gamma, reactions, axis)
    short = Abbreviations(chain(terms.phi, *rows))
    count = len(terms.phi)
    phis = [r"\Phi" if count == 1 else rf"\Phi_{{{k + 1}}}" for k in range(count)]
    phi = [(name, short(e, whole=False)) for name, e in zip(phis, terms.phi, strict=True)]
    slopes = list(_jacobian(terms, phis, short))
    right = [
        (rf"{letter}_{{{k + 1}}}" if count > 1 else letter, short(e))
        for letter, side in ((r"\nu", terms.nu), (r"\gamma", terms.gamma))
        for k, e in enumerate(side)
        if e != 0
    ]
    report = list(_reaction(element, statement, terms, short))
    yield f"## Equations\n\n{_counted(statement, phi)}"
    yield aligned(phi)
    if meanings := short.definitions():
        yield f"with\n\n{aligned(meanings)}"
    yield from _placeholders(statement, terms)
    if slopes:
        yield f"The entries of the Jacobian Φ_q that are not 0:\n\n{aligned(slopes)}"
    yield (
        "The right-hand sides of the velocities, ν = -Φ_t, and of the accelerations, "
        "γ = -(Φ_q q̇)_q q̇ - 2 Φ_qt q̇ - Φ_tt"
        + (f", where they are not 0:\n\n{aligned(right)}" if right else ", are 0.")
    )
    yield "## Reaction\n\n" + "\n\n".join(report)


def effect_sections(equations: Equations, element: Effect) -> Iterator[str]:
    """V and Q of a force, and its switching functions."""
    (terms,) = (e.terms for e in equations.effects if e.name == element.name)
    switches_of_effect = [s for s in equations.switches if s.effect == element.name]
    switches = [s.g for s in switches_of_effect]
    rubbing = [] if terms.friction is None else list(_friction(terms.friction))
    shown = [e for _, e in (*terms.gradient, *terms.forces, *rubbing)]
    energy = [] if terms.potential is None else [terms.potential]
    short = Abbreviations(chain(energy, shown, switches))
    other = "The other generalized forces" if energy else "The generalized forces"
    sections: list[tuple[str, Pairs]] = [
        ("The potential energy, J", [("V", short(e)) for e in energy]),
        (
            "Its gradient; the generalized forces are its negative",
            [(rf"V_{{{latex(q)}}}", short(e)) for q, e in terms.gradient if e != 0],
        ),
        (
            f"{other}, in N along lengths and in N m along angles",
            [(rf"Q_{{{latex(q)}}}", short(e)) for q, e in terms.forces],
        ),
        (
            "The slip, the normal force N from the joint's reaction, and the force along the slip",
            [(left, short(e)) for left, e in rubbing],
        ),
    ]
    modes = [(f"g_{{{k}}}", short(g)) for k, g in enumerate(switches, 1)]
    yield "## Equations"
    yield from (f"{title}:\n\n{aligned(rows)}" for title, rows in sections if rows)
    if meanings := short.definitions():
        yield f"with\n\n{aligned(meanings)}"
    if modes:
        many = "Switching functions: their" if len(modes) > 1 else "A switching function: its"
        yield f"{many} change of sign is an event of a run.\n\n{aligned(modes)}"
    for k, switch in enumerate(switches_of_effect, 1):
        if switch.kind in HELD:
            yield HELD[switch.kind].format(g=f"$g_{{{k}}}$")
    if switches_of_effect and switches_of_effect[0].ratio is not None:
        yield (
            "There the size of σ is at most the ratio of static to kinetic friction:\n\n"
            f"{aligned([(SIZE, short(switches_of_effect[0].ratio))])}"
        )


def _friction(terms: FrictionTerms) -> Iterator[tuple[str, sympy.Expr]]:
    """ṡ, the sizes N of the loads, and f; and Q = f s_q."""

    def load(components: tuple[tuple[str, sympy.Expr], ...]) -> sympy.Expr:
        """A sum of components of the joint's reaction."""
        names = {
            name: "T" if name == "torque" else f"{name[0]}_{name[1:]}" for name, _ in components
        }
        return sympy.Add(*(weight * given(names[name]) for name, weight in components))

    yield r"\dot s", terms.slip
    squares = ([load(entry) ** 2 for entry in contact] for contact in terms.contacts)
    yield "N", sympy.Add(*(sympy.sqrt(sympy.Add(*each)) for each in squares))
    yield "f", -terms.grip * given("N")
    for q, slope in terms.direction:
        yield rf"Q_{{{latex(q)}}}", given("f") * slope


def _counted(statement: Statement, phi: Pairs) -> str:
    rows = ", ".join(f"`{row}`" for row in statement.rows)
    number = NUMBERS[len(phi)] if len(phi) < len(NUMBERS) else str(len(phi))
    text = f"{number} equation{'s' if len(phi) > 1 else ''} Φ = 0: {rows}."
    for row, q in statement.own:
        place = next((k for k, v in statement.bindings.items() if v == q), q)
        text += f" The coordinate ${latex(place)}$ is the element's own; `{row}` determines it."
    return text


def _jacobian(
    terms: ConstraintTerms, phis: list[str], short: Abbreviations
) -> Iterator[tuple[str, sympy.Expr]]:
    for name, row in zip(phis, terms.jacobian, strict=True):
        entries = zip(terms.coordinates, row, strict=True)
        for q, entry in sorted(entries, key=lambda pair: _place(pair[0])):
            if entry != 0:
                yield rf"\partial {name} / \partial {latex(q)}", short(entry)


def _place(q: Coordinate) -> tuple[str, int]:
    """Body by body, in the order x, y, φ."""
    owner, _, letter = q.name.rpartition("_")
    return owner, list(KINDS).index(letter)


def _placeholders(statement: Statement, terms: ConstraintTerms) -> Iterator[str]:
    """The meanings of the letters that stand for neither coordinates nor points."""
    seen = set(kinds(sympy.Tuple(*terms.phi, *(e for _, _, e in terms.reactions)), Given))
    letters_shown = []
    for place, value in statement.bindings.items():
        framed = FRAMED.fullmatch(place.name)
        if place in seen and not (framed and framed[2] == "s"):
            meaning = f"`{value.name}`" if value.is_Symbol else f"${latex(lettered(value))}$"
            letters_shown.append(f"${latex(place)}$ (`{place.name}`) is {meaning}")
    if letters_shown:
        yield f"In the example {', '.join(letters_shown)}."


def _reaction(
    element: Constraint, statement: Statement, terms: ConstraintTerms, short: Abbreviations
) -> Iterator[str]:
    reaction = statement.reaction
    if isinstance(reaction, JointReaction):
        on, other = ("j", "i") if reaction.on is J else ("i", "j")
        giver, taker = (other, on) if reaction.sign > 0 else (on, other)
        where = (
            f"the element's point of body {on}" if reaction.arm is None else "the point of contact"
        )
        yield (
            f"The force and the torque of body {giver} on body {taker} act at {where}. The x axis "
            "of their components is"
        )
        ux, uy = map(short, reaction.direction)
        yield aligned([("u_x", ux), ("u_y", uy)])
    else:
        yield "Force (if Φ is a length) or torque (if Φ is an angle) that enforces each equation:"
    components = []
    for name, unit, e in terms.reactions:
        brackets = rf"\;[\mathrm{{{unit}}}]".replace(" ", r"\,") if unit else ""
        components.append((rf"\mathrm{{{name}}}{brackets}", short(e)))
    yield aligned(components)
    names = ", ".join(f'`r.reaction("{element.name}", "{name}")`' for name, *_ in terms.reactions)
    yield f"In a result of the example: {names}."

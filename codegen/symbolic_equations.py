"""The equations of a scene as matrices of SymPy, in the symbols of its declaration."""

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import sympy

from codegen.declare.space_body import matrix_g
from codegen.declare.symbols import Multiplier, Parameter, QuasiCoordinate
from codegen.derive.constraint_terms import statement_terms
from codegen.derive.equations import Equations, derive
from codegen.latex import latex
from codegen.reading.scene_selection import valid_scenes

if TYPE_CHECKING:
    from codegen.model import Model

MOST = 9  # layout: rows or columns of a matrix that is shown in full


@dataclass(frozen=True)
class SceneEquations:
    """M q̈ + Φ_qᵀ λ = Q, Φ(q, t) = 0, Φ_q q̇ = ν and Φ_q q̈ = γ, as matrices of SymPy.

    Notebooks show them. If a force has modes, such as a friction that sticks, Q contains the symbol
    of its side; if a friction follows from a reaction, Q contains the multipliers.

    Attributes
    ----------
    q, v
        Coordinates and velocities, n × 1.
    M, Q
        Mass matrix, n × n, and generalized forces, n × 1, including those of potentials. Zero in
        kinematic scenes.
    Phi, Phi_q, nu, gamma
        Constraints, m × 1, their Jacobian, m × n, and the right sides, m × 1.
    lam
        Multipliers λ, m × 1.
    constraints
        The name and the word of each row of Φ.
    parameters
        Parameter → its value in the scene, for ``M.subs(parameters)``.
    """

    q: "sympy.Matrix"
    v: "sympy.Matrix"
    M: "sympy.Matrix"
    Q: "sympy.Matrix"
    Phi: "sympy.Matrix"
    Phi_q: "sympy.Matrix"
    nu: "sympy.Matrix"
    gamma: "sympy.Matrix"
    lam: "sympy.Matrix"
    constraints: tuple[tuple[str, str], ...]
    parameters: "dict[sympy.Symbol, float]"

    def _repr_latex_(self) -> str:
        """For notebooks: the matrices; of a large one its size, and how many entries it has."""
        names = {"v": r"\dot q", "Phi": r"\Phi", "Phi_q": r"\Phi_q", "nu": r"\nu",
                 "gamma": r"\gamma", "lam": r"\lambda"}  # fmt: skip
        matrices = [(f.name, getattr(self, f.name)) for f in fields(self)[:9]]
        rows = (rf"{names.get(name, name)} &= {_shown(matrix)}" for name, matrix in matrices)
        return "$$\n\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}\n$$"


def _shown(matrix: sympy.Matrix) -> str:
    rows, columns = matrix.shape
    if max(rows, columns) > MOST:
        count = sum(e != 0 for e in matrix)
        return rf"\text{{{rows} × {columns}, {count} entries are not 0}}"
    if not rows:
        return r"\text{none}"
    return rf"{latex(matrix.T)}^{{\mathsf T}}" if columns == 1 else latex(matrix)


def scene_equations(model: "Model", scene: Any = None) -> SceneEquations:
    """The equations of a scene of a model, by default the first."""
    chosen, *_ = valid_scenes(model, None if scene is None else (scene,))
    found = derive(model, chosen)
    columns = {q: k for k, q in enumerate(found.coordinates)}
    statements = []
    for one in found.constraints:  # in the coordinates of the model
        phi = tuple(e.xreplace(one.statement.bindings) for e in one.terms.phi)
        bound = replace(one.statement, phi=phi, bindings={}, reaction=None)
        statements.append(statement_terms(bound))
    words = tuple((one.name, word) for one in found.constraints for word in one.statement.rows)
    lam = [Multiplier(f"lambda_{k}", real=True) for k in range(len(words))]
    n = len(columns)
    mass, force, slopes = sympy.zeros(n), sympy.zeros(n, 1), sympy.zeros(len(words), n)
    rows = ((terms.coordinates, entries) for terms in statements for entries in terms.jacobian)
    for row, (own, entries) in enumerate(rows):
        for q, entry in zip(own, entries, strict=True):
            slopes[row, columns[q]] = entry
    for i, k, entry in found.mass:
        mass[i, k] = entry
    for k, push in (*found.inertia_force, *_forces(found, columns, words, lam)):
        force[k] += push
    parts = ([e for terms in statements for e in getattr(terms, name)] for name in
             ("phi", "nu", "gamma"))  # fmt: skip
    phi, nu, gamma = (sympy.Matrix(len(words), 1, part) for part in parts)
    q = sympy.Matrix(n, 1, found.coordinates)
    return SceneEquations(
        q, q.applyfunc(lambda one: one.rate), mass, force, phi, slopes, nu, gamma,
        sympy.Matrix(len(words), 1, lam), words,
        {Parameter(p.name, real=True): p.value for p in found.parameters},
    )  # fmt: skip


def _forces(
    found: Equations, columns: dict[sympy.Symbol, int], words: tuple[tuple[str, str], ...],
    lam: list[Multiplier],
) -> Iterator[tuple[int, sympy.Expr]]:  # fmt: skip
    """(column, Q) of each effect; a friction has the reaction of its joint, in multipliers."""
    joints = {one.name: one for one in found.constraints}
    ways = {q: {k: sympy.S.One} for q, k in columns.items()}
    for body in found.turning:  # of torques n', Q_p = 2 Gᵀ n'
        for axis, row in zip("xyz", matrix_g(body.p).tolist(), strict=True):
            shares = {columns[e]: 2 * g for e, g in zip(body.p, row, strict=True)}
            ways[QuasiCoordinate(f"{body.name}_turn{axis}", real=True)] = shares
    for terms in (effect.terms for effect in found.effects):
        yield from ((columns[q], -slope) for q, slope in terms.gradient)
        yield from ((k, share * push) for q, push in terms.forces for k, share in ways[q].items())
        if (rubs := terms.friction) is None:
            continue
        joint = joints[rubs.joint]
        own = [one for one, (name, _) in zip(lam, words, strict=True) if name == rubs.joint]
        place = joint.statement.bindings | dict(zip(joint.terms.multipliers, own, strict=True))
        parts = {word: value.xreplace(place) for word, _, value in joint.terms.reactions}
        normal = sympy.Add(*(
            sympy.sqrt(sympy.Add(*(
                sympy.Add(*(factor * parts[word] for word, factor in entry)) ** 2
                for entry in contact
            )))
            for contact in rubs.contacts
        ))  # fmt: skip
        yield from ((columns[q], -rubs.grip * normal * slope) for q, slope in rubs.direction)

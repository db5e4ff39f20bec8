"""Equations of joints in space in vectors: Φ, its slopes by positions and turns, and γ.

With the bodies' axes along the global ones, Φ is a polynomial in the components of their vectors,
as it holds in every pose. It is taken apart into products c uᵀv of vectors of the bodies, global
axes and the way d between the points, and from those of each product follow

    δu = δπ × u,   δd = δr_j + δπ_j × s_j - δr_i - δπ_i × s_i,   γ = -c (üᵀv + 2 u̇ᵀv̇ + uᵀv̈).
"""

import re
from itertools import combinations_with_replacement

import sympy

from codegen.declare.rotation_entries import RotationEntry
from codegen.declare.space_frame import I, J
from codegen.declare.symbols import Given, given, kinds
from codegen.elements.space.joints import THETA
from codegen.errors import ModelError
from codegen.latex import latex

PLACED = re.compile(r"([ij])_([a-z])([xyz])")
ANGLE, RATE = sympy.symbols(r"theta \dot\theta", real=True)
NUMBERS = {given("cosine"): sympy.cos(sympy.Symbol("alpha")), given("lead"): sympy.Symbol("L")}
AXES = (r"\hat x", r"\hat y", r"\hat z")
Products = list[tuple[sympy.Expr, str, str]]


def _components(vector: str) -> sympy.Matrix:
    return sympy.Matrix(sympy.symbols([f"{vector}{c}" for c in "xyz"]))


def products(phi: sympy.Expr) -> tuple[Products, sympy.Expr]:
    """Φ as products of vectors, and what else is in it; ModelError if vectors are."""
    names = {s: PLACED.fullmatch(s.name) for s in kinds(phi, Given)}
    back = {s: sympy.Symbol(f"{m[2]}_{m[1]}{m[3]}") for s, m in names.items() if m}
    own = sorted({s.name[:3] for s in back.values()} - {"s_i", "s_j"})
    back |= {e: sympy.eye(3)[int(e.args[0]), int(e.args[1])] for e in phi.atoms(RotationEntry)}
    way = _components("d")
    ends = dict(zip(J.r, I.r + _components("s_i") + way - _components("s_j"), strict=True))
    rest = sympy.expand(phi.xreplace(NUMBERS | back).xreplace(ends))
    found: Products = []
    for u, v in combinations_with_replacement([*own, "d"], 2):
        slope = sympy.diff(rest, _components(u)[0], _components(v)[0])
        found.append((slope / 2 if u == v else slope, u, v))
        rest = sympy.expand(rest - found[-1][0] * _components(u).dot(_components(v)))
    for axis, component in zip(AXES, way, strict=True):
        found.append((sympy.diff(rest, component), axis, "d"))
        rest = sympy.expand(rest - found[-1][0] * component)
    if rest.has(*I.r, *(x for vector in (*own, "d") for x in _components(vector))):
        raise ModelError(f"{phi} is no sum of products of vectors.")
    return [one for one in found if one[0] != 0], rest


def slopes(found: Products) -> dict[str, Products]:
    """The columns of r and π of both bodies that are not 0, as factors and cross products."""
    columns: dict[str, Products] = {}
    for c, *pair in found:
        for u, v in (pair, pair[::-1]):  # the slope by u; twice that of dᵀd
            for body, factor in (("i", -c), ("j", c)) if u == "d" else ():
                columns.setdefault(f"r_{body}", []).append((factor, "", v))
                columns.setdefault(rf"\pi_{body}", []).append((factor, f"s_{body}", v))
            if u not in ("d", *AXES):
                columns.setdefault(rf"\pi_{u[-1]}", []).append((c, u, v))
    return dict(sorted(columns.items(), key=lambda pair: (pair[0][-1], pair[0][0] != "r")))


def gamma(found: Products, rest: sympy.Expr) -> Products:
    """γ by derivatives of the vectors without accelerations; axes have none."""
    terms: Products = [(-sympy.diff(rest, ANGLE, 2) * RATE**2, "", "")]
    for c, u, v in found:
        turned, bent = 2 * sympy.diff(c, ANGLE) * RATE, sympy.diff(c, ANGLE, 2) * RATE**2
        ways = [(c, r"\ddot ", ""), (2 * c, r"\dot ", r"\dot "), (c, "", r"\ddot ")]
        ways += [(turned, r"\dot ", ""), (turned, "", r"\dot "), (bent, "", "")]
        terms += [(-f, a + u, b + v) for f, a, b in ways if not (a and u in AXES)]
    return terms


def written(terms: Products, between: str = "^T") -> str:
    """A sum of factors and products of two vectors in LaTeX, equal ones together."""
    totals, shown = dict[str, sympy.Expr](), ""
    for factor, u, v in terms:
        text = (f"{{{u}}}{between} " if u else "") + v
        totals[text] = totals.get(text, sympy.S.Zero) + factor
    for text, factor in totals.items():
        for part in (factor,) if text else factor.as_ordered_terms():
            minus = part.could_extract_minus_sign()
            size = latex(-part if minus else part)
            front = "" if size == "1" and text else size + (r"\, " if text else "")
            shown += f" {'-' if minus else '+'} {front}{text}" if part != 0 else ""
    return shown.removeprefix(" + ").strip() or "0"


def block(phi: tuple[sympy.Expr, ...]) -> str:
    """``$$ … $$`` with Φ, the entries of Φ_q that are not 0, and γ, row by row."""
    rows = []
    for k, stated in enumerate(phi, 1):
        name = rf"\Phi_{{{k}}}" if len(phi) > 1 else r"\Phi"
        found, rest = products(stated.xreplace({THETA: ANGLE}))
        rows.append((name, written([*found, (rest, "", "")])))
        of_angle = [(sympy.diff(c, ANGLE), u, v) for c, u, v in (*found, (rest, "", ""))]
        columns = {q: written(by, r" \times") for q, by in slopes(found).items()}
        columns[r"\theta"] = written(of_angle)
        rows += [(rf"\partial {name} / \partial {q}", x) for q, x in columns.items() if x != "0"]
        rows.append((name.replace("Phi", "gamma"), written(gamma(found, rest))))
    lines = " \\\\\n".join(f"{left} &= {right}" for left, right in rows)
    return f"$$\n\\begin{{aligned}}\n{lines}\n\\end{{aligned}}\n$$"

"""Switching functions without poles: a/b > 0 is a b > 0, wherever b is not zero.

At a pole a function changes its sign without a zero, which no step shows and no location finds.
Nothing here is by pieces: SymPy takes these out of conditions, whose logic tells them apart.
"""

from functools import cache

import sympy

from codegen.declare.symbols import Coordinate, Time, Velocity, kinds

_EXPONENTIALS = (sympy.exp, sympy.sinh, sympy.cosh)
_INVERSES = {sympy.exp: sympy.log, sympy.sinh: sympy.asinh}
"""The inverses of increasing functions without bounds: f(u) > c is u > f⁻¹(c)."""


class _Power(sympy.Symbol):  # type: ignore[misc]
    """exp(u) for a u that has a pole."""


@cache
def without_poles(g: sympy.Expr) -> sympy.Expr:
    """A function that has the sign of `g` wherever `g` has a number, and no pole in what moves.

    It is `g` itself where this has none. A pole inside exp, sinh or cosh is seen where `g` is made
    of these by sums, products and whole powers, with one exponent; else poles inside functions
    stay.
    """
    g = _with_inverse(g)
    if not _has_pole(g):
        return g
    exponent = _exponent(g)
    if exponent is None:
        return _over_no_bottom(g)
    power = _Power("power", positive=True)
    try:
        polynomial = sympy.Poly(_over_no_bottom(_with_powers(g, exponent, power)), power)
    except sympy.PolynomialError:  # a power inside another function
        return _over_no_bottom(g)
    return _bounded(polynomial, exponent)


def _over_no_bottom(g: sympy.Expr) -> sympy.Expr:
    """a b, or a where b has no sign, of g = a/b."""
    top, bottom = sympy.fraction(sympy.together(_with_fractions(g)))
    return sympy.Mul(top, *(_sign(factor, top) for factor in sympy.Mul.make_args(bottom)))


def _exponent(g: sympy.Expr) -> sympy.Expr | None:
    """u, if all exponentials with a pole are powers exp(k u) with whole k."""
    nodes = [node for node in g.atoms(*_EXPONENTIALS) if _has_pole(node)]
    factors, others = zip(*map(_factor, nodes), strict=True) if nodes else ((), ())
    if len({*others}) != 1:
        return None
    return others[0] / sympy.ilcm(1, *(factor.q for factor in factors))


def _factor(node: sympy.Expr) -> tuple[sympy.Rational, sympy.Expr]:
    """The number and the rest of an exponent."""
    number, rest = node.args[0].as_coeff_Mul(rational=True)
    return number, rest


def _with_powers(g: sympy.Expr, exponent: sympy.Expr, power: sympy.Symbol) -> sympy.Expr:
    """The same with a symbol for exp(exponent)."""
    number, _ = exponent.as_coeff_Mul(rational=True)
    symbols = {}
    for node in g.atoms(*_EXPONENTIALS):
        if _has_pole(node):
            high = power ** (_factor(node)[0] / number)
            less = {sympy.exp: 0, sympy.sinh: -1 / high, sympy.cosh: 1 / high}[node.func]
            symbols[node] = (high + less) / (1 if node.func is sympy.exp else 2)
    return g.xreplace(symbols)


def _bounded(polynomial: sympy.Poly, u: sympy.Expr) -> sympy.Expr:
    """A function with the sign of a polynomial in y = exp(u), none of whose terms is unbounded.

    Over (1 + y)ⁿ, with T = tanh(u/2), yᵏ becomes (1 + T)ᵏ (1 - T)ⁿ⁻ᵏ. A factor of y as a number
    goes into the exponent first, so that the zero is where T has digits.
    """
    terms = [(k, c) for (k,), c in polynomial.terms()]
    (high, first), (low, last) = terms[0], terms[-1]
    if high == low:
        return first
    ratio = abs(last.as_coeff_Mul()[0] / first.as_coeff_Mul()[0])
    scale = sympy.Float(ratio) ** (1 / (high - low)) if ratio != 1 else sympy.S.One
    bend = sympy.tanh((u - sympy.log(scale)) / 2)
    return sympy.Add(
        *(c * scale**k * (1 + bend) ** (k - low) * (1 - bend) ** (high - k) for k, c in terms)
    )


def _with_inverse(g: sympy.Expr) -> sympy.Expr:
    """k (u - f⁻¹(c)) for k (f(u) - c) with a pole in u, and any other function itself."""
    symbols = kinds(g, Coordinate, Velocity, Time)
    constant, rest = g.as_independent(*symbols, as_Add=True)
    factor, increasing = rest.as_independent(*symbols, as_Add=False)
    inverse = _INVERSES.get(increasing.func)
    if inverse is None or factor.is_nonzero is not True or not _has_pole(increasing.args[0]):
        return g
    level = inverse(-constant / factor)
    return factor * (increasing.args[0] - level) if level.is_extended_real else g


def _has_pole(node: sympy.Basic) -> bool:
    """Whether a sum, product, power or exp may become infinite; lengths' broken powers may not."""
    if isinstance(node, _EXPONENTIALS):
        return _has_pole(node.args[0])
    if isinstance(node, sympy.Pow) and node.exp.is_number and _moves(node.base):
        base, whole = node.base, bool(node.exp.is_integer)
        never = base.is_positive if whole else base.is_nonnegative
        return bool(node.exp.is_negative and not never) or (whole and _has_pole(base))
    if isinstance(node, sympy.Add | sympy.Mul):
        return any(map(_has_pole, node.args))
    return isinstance(node, sympy.tan) and _moves(node)


def _moves(node: sympy.Basic) -> bool:
    return bool(kinds(node, Coordinate, Velocity, Time, _Power))


def _with_fractions(node: sympy.Expr) -> sympy.Expr:
    """The same with tan(u) as sin(u)/cos(u) wherever its poles count."""
    if isinstance(node, sympy.tan):
        return sympy.sin(*node.args) / sympy.cos(*node.args)
    if isinstance(node, sympy.Pow) and node.exp.is_Float:  # SymPy takes no x**-1.5 for a fraction
        node = sympy.Pow(node.base, sympy.Rational(str(node.exp)))
    if isinstance(node, sympy.Add | sympy.Mul) or (node.is_Pow and node.exp.is_integer):
        return node.func(*map(_with_fractions, node.args))
    return node


def _sign(factor: sympy.Expr, top: sympy.Expr) -> sympy.Expr:
    """A factor with the sign of this one below `top`, 1 where it is positive."""
    base, exponent = factor.as_base_exp()
    if not _moves(factor):
        return 1 / factor
    if exponent.is_even or base.is_nonnegative:
        return sympy.S.One
    if exponent.is_integer or not exponent.is_number:
        return base if exponent.is_odd else factor
    # Neither has a number where the base of a broken power is negative.
    ends = any(root.base == base and not root.exp.is_integer for root in top.atoms(sympy.Pow))
    return sympy.S.One if ends else base

"""The rotation of a body in space, as functions of its Euler parameters p = (e0, e).

    A = (2 e0² - 1) I + 2 (e eᵀ + e0 ẽ),   ω' = 2 G ṗ,   G = [-e, -ẽ + e0 I],   pᵀp = 1

The entries of A and the components of ω' are functions of SymPy, each known as a whole. Calculus
sees the Euler parameters in them, and `codegen.lower` computes them once for each body (E. J. Haug,
Computer-Aided Kinematics and Dynamics of Mechanical Systems, 1989, 9.3).
"""

from typing import Any

import sympy

AXES = "xyz"
G = (
    ((-1, 1), (1, 0), (1, 3), (-1, 2)),
    ((-1, 2), (-1, 3), (1, 0), (1, 1)),
    ((-1, 3), (1, 2), (-1, 1), (1, 0)),
)
"""(sign, k) of each entry ± e_k of G."""
E = (
    ((-1, 1), (1, 0), (-1, 3), (1, 2)),
    ((-1, 2), (1, 3), (1, 0), (-1, 1)),
    ((-1, 3), (-1, 2), (1, 1), (1, 0)),
)
"""The same of E = [-e, ẽ + e0 I], with which ω = 2 E ṗ in global axes."""
_MATRIX = tuple((i, k) for i in range(3) for k in range(3))


class _Entry(sympy.Function):  # type: ignore[misc]
    """A function whose first arguments are numbers of axes, and whose others are real."""

    axes = 1

    @classmethod
    def eval(cls, *args: Any) -> Any:
        """The number, where all arguments are numbers."""
        at = args[cls.axes :]
        return cls._polynomial(*args) if all(a.is_number for a in at) else None

    @classmethod
    def _polynomial(cls, *args: Any) -> Any:
        raise NotImplementedError

    def polynomial(self) -> sympy.Expr:
        """The function written out."""
        return self._polynomial(*self.args)

    def fdiff(self, argindex: int = 1) -> sympy.Expr:
        """∂/∂ of an argument."""
        places = sympy.symbols(f"a:{len(self.args)}", cls=sympy.Dummy)
        at = (*self.args[: self.axes], *places[self.axes :])
        slope = sympy.diff(self._polynomial(*at), places[argindex - 1])
        return slope.xreplace(dict(zip(places, self.args, strict=True)))

    def _eval_is_extended_real(self) -> bool:
        return True

    def _eval_is_finite(self) -> bool:
        return True

    def _sympystr(self, printer: Any) -> str:
        owner = str(self.args[self.axes]).rpartition("_")[0]
        return f"{owner}_{self.symbol}{''.join(AXES[int(k)] for k in self.args[: self.axes])}"

    def _latex(self, printer: Any, exp: str = "") -> str:
        name = rf"\mathtt{{{str(self).replace('_', chr(92) + '_')}}}"
        return rf"{{{name}}}^{{{exp}}}" if exp else name


class RotationEntry(_Entry):
    """A_ik(e0, e1, e2, e3), of arguments i, k, e0, e1, e2, e3."""

    axes = 2
    symbol = "A"

    @classmethod
    def _polynomial(cls, i: Any, k: Any, e0: Any, *e: Any) -> sympy.Expr:
        i, k = int(i), int(k)
        if i == k:
            return 2 * (e0**2 + e[i] ** 2) - 1
        sign = 1 if (i - k) % 3 == 1 else -1
        return 2 * (e[i] * e[k] + sign * e0 * e[3 - i - k])


class SpinEntry(_Entry):
    """ω'_k(p, ṗ), of arguments k, e0, e1, e2, e3, ė0, ė1, ė2, ė3."""

    symbol = "omega_"

    @classmethod
    def _polynomial(cls, k: Any, *at: Any) -> sympy.Expr:
        p, rates = at[:4], at[4:]
        signs = zip(G[int(k)], rates, strict=True)
        return 2 * sympy.Add(*(sign * p[j] * rate for (sign, j), rate in signs))


def product(a: Any, b: Any) -> tuple[Any, ...]:
    """The product of two quaternions, Euler parameters of one turn after another."""
    u, v = sympy.Matrix(a[1:]), sympy.Matrix(b[1:])
    return (a[0] * b[0] - u.dot(v), *(a[0] * v + b[0] * u + u.cross(v)))


def conjugate(p: Any) -> tuple[Any, ...]:
    """The Euler parameters of the opposite turn."""
    return (p[0], *(-e for e in p[1:]))


# safety: below rounding; added to sin² χ/2, so that its root has a slope at 0, and to cos χ/2, so
# that a half turn does not divide by 0
SMALLEST = 1e-16


class RotationVectorEntry(_Entry):
    """θ_k of the rotation vector of A_iᵀ A_j D, of k and the Euler parameters of i, of j and D.

    With the Euler parameters (w, v) of this turn by χ, θ = (v / |v|) 2 atan(|v| / w), the same for
    (-w, -v): it is exact up to half a turn, and smooth at 0. At half a turn it has the value of one
    side, along v.
    """

    @classmethod
    def _polynomial(cls, k: Any, *at: Any) -> sympy.Expr:
        w, *v = product(product(conjugate(at[:4]), at[4:8]), at[8:])
        sine = sympy.sqrt(sympy.Add(*(x**2 for x in v)) + SMALLEST)
        return v[int(k)] * (2 * sympy.atan(sine / (w + SMALLEST)) / sine)

    def _sympystr(self, printer: Any) -> str:
        return f"theta({', '.join(map(str, self.args))})"


ENTRIES = (RotationEntry, SpinEntry, RotationVectorEntry)


def rotation_matrix(p: tuple[Any, ...]) -> sympy.ImmutableMatrix:
    """A of Euler parameters, 3 × 3."""
    return sympy.ImmutableMatrix(3, 3, [RotationEntry(i, k, *p) for i, k in _MATRIX])


def spin(p: tuple[Any, ...], rates: tuple[Any, ...]) -> tuple[sympy.Expr, ...]:
    """ω' of Euler parameters and their rates."""
    return tuple(SpinEntry(k, *p, *rates) for k in range(3))

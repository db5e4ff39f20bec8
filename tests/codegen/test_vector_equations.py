"""Equations of joints in space as pages show them, against Φ and its differences."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy

from codegen.declare.rotation_entries import RotationEntry
from codegen.declare.symbols import Given, coordinate, given, kinds
from codegen.elements.registry import kinds_of_elements
from codegen.elements.space.joints import THETA, JointInSpace
from codegen.errors import ModelError
from codegen.reference.vector_equations import ANGLE, NUMBERS, RATE, gamma, products, slopes
from tests.space.rotations import about, parameters_of, unit

JOINTS = {
    name: kind.element
    for name, kind in kinds_of_elements(space=True).items()
    if issubclass(kind.element, JointInSpace) and not kind.is_user_defined
}
LETTERS = ("x", "y", "z", "e0", "e1", "e2", "e3")
NUMERIC = {given("length"): 1.3, given("cosine"): 0.4, given("lead"): 0.7, given("offset"): 0.2}


class Pair:
    """Two bodies that turn with constant ω and move with constant ṙ, and vectors fixed in them."""

    def __init__(self, joint: type[JointInSpace]) -> None:
        rng = np.random.default_rng(5)
        self.poses = {b: (rng.normal(size=3), about(unit(rng), 1.1)) for b in "ij"}
        self.speeds = {b: tuple(rng.normal(size=(2, 3))) for b in "ij"}
        self.angle, self.rate = 0.6, 0.9
        letters = {s.name[:3] for e in joint.phi for s in kinds(e, Given) if s.name[1] == "_"}
        self.fixed = {name: rng.normal(size=3) for name in sorted(letters | {"i_s", "j_s"})}

    def moved(
        self, **by: tuple[np.ndarray, np.ndarray]
    ) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """The poses after translations and turns of bodies."""
        found = dict(self.poses)
        for body, (way, turn) in by.items():
            r, a = found[body]
            size = float(np.linalg.norm(turn))
            found[body] = r + way, (about(turn / size, size) if size else np.eye(3)) @ a
        return found

    def phi(self, row: sympy.Expr) -> Callable[[dict[str, Any], float], float]:
        """Φ of one row, as a function of the poses and of the joint's angle."""
        own = {coordinate(b, c): (b, k) for b in "ij" for k, c in enumerate(LETTERS)}
        fixed = {
            given(f"{name}{c}"): x
            for name, vector in self.fixed.items()
            for c, x in zip("xyz", vector, strict=True)
        }
        entries = {e: e.polynomial() for e in row.atoms(RotationEntry)}
        written = row.xreplace(entries).xreplace(NUMERIC | fixed)
        made = sympy.lambdify([*own, THETA], written, "math")

        def value(poses: dict[str, Any], angle: float) -> float:
            q = {body: (*r, *parameters_of(a)) for body, (r, a) in poses.items()}
            return float(made(*(q[body][k] for body, k in own.values()), angle))

        return value

    def vectors(self) -> dict[str, np.ndarray]:
        """Letters of a page → their values."""
        found, arms = {}, {}
        for name, vector in self.fixed.items():
            body, letter = name.split("_")
            w, turned = self.speeds[body][1], self.poses[body][1] @ vector
            twice = np.cross(w, np.cross(w, turned))
            for dots, value in (("", turned), ("dot", np.cross(w, turned)), ("ddot", twice)):
                key = f"{letter}_{body}"
                found[rf"\{dots} {key}" if dots else key] = value
                if letter == "s":
                    arms[body, dots] = value
        for dots, ends in (
            ("", [r for r, _ in self.poses.values()]),
            ("dot", [v for v, _ in self.speeds.values()]),
            ("ddot", [0, 0]),
        ):
            way = ends[1] + arms["j", dots] - ends[0] - arms["i", dots]
            found[rf"\{dots} d" if dots else "d"] = way
        return found | {rf"\hat {c}": np.eye(3)[k] for k, c in enumerate("xyz")}


@pytest.mark.parametrize("kind", JOINTS)
def test_equations_in_vectors_are_those_of_the_element(kind: str) -> None:
    joint = JOINTS[kind]
    pair = Pair(joint)
    vectors = pair.vectors()
    numbers = {ANGLE: pair.angle, RATE: pair.rate}
    numbers |= {NUMBERS.get(k, k): x for k, x in NUMERIC.items()}
    numbers[sympy.Symbol("alpha")] = np.arccos(0.4)

    def number(e: sympy.Expr) -> float:
        return float(sympy.sympify(e).subs(numbers))

    nothing = np.zeros(3)
    for row in joint.phi:
        phi = pair.phi(row)
        found, rest = products(row.xreplace({THETA: ANGLE}))
        here = phi(pair.poses, pair.angle)
        whole = sum(number(c) * vectors[u] @ vectors[v] for c, u, v in found)
        assert whole + number(rest) == pytest.approx(here, abs=1e-12)
        columns = {
            name: sum(
                number(c) * (np.cross(vectors[u], vectors[v]) if u else vectors[v])
                for c, u, v in terms
            )
            for name, terms in slopes(found).items()
        }
        for body in "ij":
            for k, name in enumerate((f"r_{body}", rf"\pi_{body}")):
                for axis in 1e-6 * np.eye(3):
                    ends = [
                        phi(
                            pair.moved(**{body: (nothing, s * axis) if k else (s * axis, nothing)}),
                            pair.angle,
                        )
                        for s in (1.0, -1.0)
                    ]
                    slope = (ends[0] - ends[1]) / 2e-6
                    shown = columns.get(name, nothing) @ axis / 1e-6
                    assert shown == pytest.approx(slope, abs=1e-8), name
        step = 1e-4
        after, before = (
            phi(
                pair.moved(**{b: (h * v, h * w) for b, (v, w) in pair.speeds.items()}),
                pair.angle + h * pair.rate,
            )
            for h in (step, -step)
        )
        bend = sum(
            number(f) * (vectors[x] @ vectors[y] if x else 1.0) for f, x, y in gamma(found, rest)
        )
        assert bend == pytest.approx(-(after - 2 * here + before) / step**2, abs=1e-5)


def test_what_is_no_sum_of_products_is_refused() -> None:
    joint = JOINTS["spherical"]
    with pytest.raises(ModelError, match="is no sum of products of vectors"):
        products(joint.phi[0] ** 3)

"""The order conditions of every tableau, from its own numbers in exact arithmetic.

A method has order p where Σ b_i η_i(τ) = 1/γ(τ) for every rooted tree τ of at most p vertices
(Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, section II.2); its dense
output has order p at the fraction x of the step where Σ b_i(x) η_i(τ) = x^|τ|/γ(τ).
"""

import logging
from collections import defaultdict
from fractions import Fraction
from functools import cache
from math import prod

import numpy as np
import pytest

from codegen.tableaus import tableaus

TABLEAUS = tableaus()
EVERY_TABLEAU = pytest.mark.parametrize("name", TABLEAUS)
ONE = Fraction(1)
# Defects left by the published digits: none for fractions, about 30 digits of dop853, 40 of tsit5
# but 17 of its dense output.
MISSING = defaultdict(Fraction, dop853=Fraction(1, 10**24), tsit5=Fraction(1, 10**36))
LOOSEST = 1e-3  # relative tolerance of a loose run
MISSING_DENSE = defaultdict(Fraction, {**MISSING, "tsit5": Fraction(1, 10**15)})

# Methods with |R(iy)| > 1 from y = 0 on: the growth is part of the error of order p.
NO_EDGE: frozenset[str] = frozenset()


@cache
def trees(order):
    """Rooted trees with `order` vertices: each is the sorted tuple of its branches."""
    if order == 1:
        return {()}
    return {grown for tree in trees(order - 1) for grown in with_a_leaf(tree)}


def with_a_leaf(tree):
    yield tuple(sorted((*tree, ())))
    for i, branch in enumerate(tree):
        for grown in with_a_leaf(branch):
            yield tuple(sorted((*tree[:i], grown, *tree[i + 1 :])))


def vertices(tree):
    return 1 + sum(map(vertices, tree))


def gamma(tree):
    return vertices(tree) * prod(map(gamma, tree))


def dot(weights, values):
    return sum((a * x for a, x in zip(weights, values, strict=False)), 0)


@cache
def eta(name, tree):
    """Elementary weights of the stages, those of the dense output included."""
    stages = TABLEAUS[name].all_stages
    branches = [[dot(stage.a, eta(name, branch)) for stage in stages] for branch in tree]
    return tuple(prod(values, start=ONE) for values in zip(*branches, strict=True)) or (
        (ONE,) * len(stages)
    )


def defects(name, weights, order, x=ONE):
    """Largest defect of the conditions of each order up to `order`."""
    return [
        max(abs(dot(weights, eta(name, tree)) - x**p / gamma(tree)) for tree in trees(p))
        for p in range(1, order + 1)
    ]


def test_number_of_trees():
    assert [len(trees(p)) for p in range(1, 9)] == [1, 1, 2, 4, 9, 20, 48, 115]


@EVERY_TABLEAU
def test_rows_sum_to_their_nodes(name):
    for stage in TABLEAUS[name].all_stages:
        assert abs(sum(stage.a) - stage.c) <= MISSING[name]


@EVERY_TABLEAU
def test_order_of_the_solution(name):
    tableau = TABLEAUS[name]
    *held, missed = defects(name, tableau.b, tableau.order + 1)
    assert max(held) <= MISSING[name]
    assert missed > 1e-9


@EVERY_TABLEAU
def test_order_of_the_error_estimate(name):
    # A difference of two solutions: that of order p vanishes on the trees up to p, no further.
    tableau = TABLEAUS[name]
    order = 5 if tableau.lower else tableau.error_order
    sums = [
        max(abs(dot(tableau.error, eta(name, t))) for t in trees(p)) for p in range(1, order + 2)
    ]
    assert max(sums[:-1]) <= MISSING[name]
    assert sums[-1] > 1e-6
    if tableau.lower:
        *held, missed = defects(name, tableau.lower, 4)
        assert max(held) <= MISSING[name]
        assert missed > 1e-6


def dense_weights(tableau, x):
    """b_i(x), from the rows of F0 + x (F1 + (1 - x) (F2 + x (F3 + ...)))."""
    count = len(tableau.all_stages)

    def row(weights):
        return np.array([*weights, *[Fraction(0)] * (count - len(weights))], dtype=object)

    first, last = row((ONE,)), row((*[Fraction(0)] * tableau.last, ONE))
    b = row(tableau.b)
    rows = [b, first - b, 2 * b - first - last, *map(row, tableau.dense)]
    total = 0 * b
    for i in reversed(range(len(rows))):
        total = (rows[i] + total) * (x if i % 2 == 0 else 1 - x)
    return total


@EVERY_TABLEAU
@pytest.mark.parametrize("x", [Fraction(1, 7), Fraction(1, 2), Fraction(9, 10)])
def test_order_of_the_dense_output(name, x):
    tableau = TABLEAUS[name]
    *held, missed = defects(name, dense_weights(tableau, x), tableau.dense_order + 1, x)
    assert max(held) <= MISSING_DENSE[name]
    assert missed > 1e-9


@EVERY_TABLEAU
def test_dense_output_is_continuous_with_its_derivative(name):
    tableau, tiny = TABLEAUS[name], Fraction(1, 10**40)
    count = len(tableau.all_stages)
    end = [*tableau.b, *[Fraction(0)] * (count - len(tableau.b))]
    assert list(dense_weights(tableau, Fraction(0))) == [0] * count
    assert list(dense_weights(tableau, ONE)) == end
    for x, sign, stage in ((Fraction(0), 1, 0), (ONE, -1, tableau.last)):
        change = dense_weights(tableau, x + sign * tiny) - dense_weights(tableau, x)
        slopes = change / (sign * tiny)
        assert all(abs(slope - (i == stage)) < 1e-30 for i, slope in enumerate(slopes))


@EVERY_TABLEAU
def test_stability_function_starts_like_the_exponential(name):
    tableau = TABLEAUS[name]
    found = tableau.stability_function
    for k in range(tableau.order + 1):
        assert abs(found[k] * prod(range(1, k + 1)) - 1) <= 10**3 * MISSING[name]
    assert len(found) == tableau.last + 1


@EVERY_TABLEAU
def test_stability_edge(name):
    # Half the error estimate of an undamped vibration, over its amplitude, where |R(iy)| exceeds 1.
    tableau = TABLEAUS[name]
    powers = np.array([float(x) for x in reversed(tableau.stability_function)])
    y = np.linspace(0.1, 7.0, 69001)
    edge = y[np.argmax(np.abs(np.polyval(powers, 1j * y)) > 1.0 + 1e-11)]
    if name in NO_EDGE:
        assert edge < 0.2
        assert tableau.stability_edge is None
        return
    states = []
    for stage in tableau.all_stages:
        states.append(1.0 + 1j * edge * dot(map(float, stage.a), states))
    half = 0.5 * edge * abs(dot(map(float, tableau.error), states))
    comparable = tableau.stages[-1].c == 1  # its state is compared with that at the end
    if tableau.stability_edge is None:
        # Beyond 5 rad no accuracy asked for permits such a step; where `half` is large, few do.
        limit = f"set stability_edge={half:.2g}" if comparable else "no stability_edge can help"
        limit = "where |R(iy)| > 1 from y = 0 on, add it to NO_EDGE" if edge < 0.2 else limit
        advice = f"{name}: above a tolerance of {half:.2g} vibrations grow: {limit}"
        if not comparable:
            logging.info(advice)
        assert edge > 5.0 or (not comparable and half >= LOOSEST), advice
        return
    assert tableau.stability_edge == pytest.approx(half, rel=0.1)
    assert comparable

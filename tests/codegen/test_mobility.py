"""Mobility by count and by rank, and Grashof's class of four-bars, in `linkwright check`."""

from collections.abc import Sequence

import pytest

from codegen import Model
from codegen.check.four_bars import four_bars
from codegen.explain.declaration_report import check_declaration


def four_bar(sizes: Sequence[float]) -> Model:
    """Crank, coupler, rocker and ground of these lengths, m."""
    model = Model("four_bar")
    ab, bc, cd, ad = (model.parameter(n, x) for n, x in zip("pqrs", sizes, strict=True))
    crank, rocker = (model.body(name, mass=1.0, inertia=1.0) for name in ("crank", "rocker"))
    model.revolute("A", model.ground.at(0, 0), crank.at(0, 0))
    model.revolute("D", model.ground.at(ad, 0), rocker.at(0, 0))
    coupler = model.body("coupler", mass=1.0, inertia=1.0)
    model.revolute("B", crank.at(ab, 0), coupler.at(0, 0))
    model.revolute("C", coupler.at(bc, 0), rocker.at(cd, 0))
    model.scene("free", guess={crank.phi: 1.0, rocker.phi: 1.5})
    return model


@pytest.mark.parametrize(
    ("sizes", "words"),
    [
        ((1.0, 2.5, 2.5, 2.0), "crank-rocker, crank turns all around (1 + 2.5 < 2 + 2.5 m)"),
        ((2.5, 2.5, 1.0, 2.0), "crank-rocker, rocker turns all around"),
        ((2.0, 2.5, 2.5, 1.0), "double crank, crank and rocker turn all around"),
        ((2.5, 1.0, 2.5, 2.0), "double rocker, coupler turns all around"),
        ((1.0, 1.4, 1.4, 2.0), "triple rocker, no link turns all around (1 + 2 > 1.4 + 1.4 m)"),
        ((1.0, 2.0, 1.0, 2.0), "change point"),
        ((9.0, 1.0, 1.0, 1.0), "cannot close, or only in one line (9 >= 1 + 1 + 1 m)"),
        ((1.0, 1.0, 1.0, 3.0), "cannot close, or only in one line"),
    ],
)
def test_grashofs_classes(sizes: Sequence[float], words: str) -> None:
    (found,) = four_bars(four_bar(sizes), ())
    assert found.startswith(f"A-B-C-D: {words}")


def test_no_class_without_a_link_or_without_numbers() -> None:
    model = four_bar((1.0, 2.5, 2.5, 2.0))
    assert four_bars(model, ("B",)) == ()
    model.parameter("unused", 1.0)
    sliding = Model("sliding")
    one = sliding.body("one", mass=1.0, inertia=1.0)
    sliding.revolute("A", sliding.ground.at(0, 0), one.at(0, 0))
    assert four_bars(sliding, ()) == ()


def test_class_with_the_values_of_each_scene() -> None:
    model = four_bar((1.0, 2.5, 2.5, 2.0))
    model.scene("short", parameters={"q": 1.4, "r": 1.4})
    free, short = (facts.four_bars[0] for facts in check_declaration(model).scenes)
    assert "crank-rocker" in free
    assert "triple rocker" in short


def test_mobility_of_a_four_bar() -> None:
    (facts,) = check_declaration(four_bar((1.0, 2.5, 2.5, 2.0))).scenes
    assert facts.mobility == (1, 1)
    assert facts.four_bars[0].startswith("A-B-C-D: crank-rocker")


def test_mobility_of_three_parallel_cranks() -> None:
    model = Model("three_cranks")
    bar = model.body("bar", mass=1.0, inertia=1.0)
    guess = {bar.x: 0.4, bar.y: 0.3}
    for k in range(3):
        crank = model.body(f"crank_{k}", mass=1.0, inertia=1.0)
        model.revolute(f"A{k}", model.ground.at(k, 0), crank.at(0, 0))
        model.revolute(f"B{k}", crank.at(0.5, 0), bar.at(k, 0))
        guess |= {crank.x: k, crank.phi: 0.65}
    model.scene("free", guess=guess)
    (facts,) = check_declaration(model).scenes
    assert facts.mobility == (0, 1)
    assert all("change point" in words for words in facts.four_bars)
    assert len(facts.four_bars) == 3

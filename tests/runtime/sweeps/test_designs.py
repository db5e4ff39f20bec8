"""Factors and designs: what a text means, grids, samples, datasets, and everything that is none."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from codegen.errors import InputError
from runtime.sweeps.design import SAMPLES, Design, read_design, read_factor, read_factors


def designed(
    over: Any, sample: str | None = None, count: int | None = None, seed: int = 0, unit: str = "m"
) -> tuple[Design, list[list[float]]]:
    """A design and its points, of factors that are all declared in one unit."""
    design, points = read_design(over, sample, count, seed, lambda name: unit)
    return design, points.tolist()


def test_texts_of_factors() -> None:
    assert (read_factor("a", "200:1000:81").values == np.linspace(200, 1000, 81)).all()
    assert read_factor("a", "225, 450,900").values.tolist() == [225.0, 450.0, 900.0]
    assert read_factor("a", "-1e3").values.tolist() == [-1000.0]
    for text in ("2:5", "uniform:2:5", ("uniform", 2, 5)):
        factor = read_factor("a", text)
        assert (factor.distribution, factor.bounds) == ("uniform", (2.0, 5.0))
    assert read_factor("a", "normal:450:20").bounds == (450.0, 20.0)
    assert read_factor("a", np.arange(3)).values.tolist() == [0.0, 1.0, 2.0]
    assert read_factor("a", 4).values.tolist() == [4.0]
    assert read_factor("a", "log:1:1000:4").values == pytest.approx([1.0, 10.0, 100.0, 1000.0])
    assert read_factor("a", "3:3:1").values.tolist() == [3.0]


def test_texts_with_units() -> None:
    lengths = ["a=100 mm:200 mm:2", "b=normal:20 degC:1 degC", "c=1 m,2 m", "d=5"]
    found = read_factors(lengths)
    assert [factor.unit for factor in found] == ["mm", "degC", "m", ""]
    assert found[0].text == "2 values from 100 to 200 mm"
    lengths = [lengths[0], lengths[2]]
    assert designed(lengths)[1] == [[0.1, 1.0], [0.1, 2.0], [0.2, 1.0], [0.2, 2.0]]
    with pytest.raises(InputError, match="a: 1 millimeter has the dimension"):
        designed(lengths, unit="kg")


def test_numbers_in_several_units() -> None:
    grid = read_factor("a", "500 mm:2 m:4")
    assert (grid.values.tolist(), grid.unit) == ([500.0, 1000.0, 1500.0, 2000.0], "mm")
    for given in ("500 mm,2 m", ["500 mm", "2 m"]):
        assert read_factor("a", given).values.tolist() == [500.0, 2000.0]
    drawn = read_factor("a", "normal:1 m:10 mm")
    assert (drawn.bounds, drawn.unit) == ((1.0, 0.01), "m")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("", "write NAME=FIRST:LAST:COUNT"),
        ("a,b", "write NAME=FIRST"),
        ("1:2:3:4", "write NAME=FIRST"),
        ("1:nan:3", "write NAME=FIRST"),
        ("1:2:2.5", "the count is 2.5; it must be a whole number"),
        ("1:2:0", "the count is 0"),
        ("1:2:1", "one value cannot be both 1 and 2"),
        ("1:2:x", "write NAME=FIRST"),
        ("1 mm:2:5", "give all numbers a unit, or none"),
        ("1 mm:2 kg:5", "2 kilogram has the dimension"),
        ("log:-1:2:5", "equal ratios lead from -1 to 2 by no way"),
        ("log:1:2", "write NAME=FIRST"),
        ("1:2:5 mm", "the count is 5"),
        ("5:2", "LOW 5 must be less than HIGH 2"),
        ("normal:1:0", "standard deviation 0 must be greater"),
        ("normal:1", "normal needs a MEAN"),
        ("gamma:1:2", "no distribution 'gamma'; there are uniform and normal"),
        ("1,1", "a value is repeated"),
        ([], "it must be numbers"),
        ([1.0, np.inf], "finite"),
        (None, "it must be numbers"),
        ({"a": 1}, "it must be numbers"),
    ],
)
def test_what_is_no_factor(given: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_factor("a", given)


def test_all_problems_of_factors_at_once() -> None:
    with pytest.raises(InputError) as caught:
        read_factors(["J1", "a=1:2:x", "b=1,2", "b=3", "=4"])
    assert len(caught.value.problems) == 4
    with pytest.raises(InputError, match="Nothing varies"):
        read_factors({})


def test_a_grid_has_every_combination_once() -> None:
    design, points = designed(["a=1,2,3", "b=10:20:2"])
    assert points == [[1, 10], [1, 20], [2, 10], [2, 20], [3, 10], [3, 20]]
    assert design.axes == {"a": 3, "b": 2}


@pytest.mark.parametrize("kind", SAMPLES)
def test_a_sample_is_that_of_its_seed_and_its_distributions(kind: str) -> None:
    if kind == "saltelli":
        pytest.importorskip("SALib")
    factors = ["a=2:4", "b=normal:10:0.5"]
    first, again, other = (np.array(designed(factors, kind, 256, seed)[1]) for seed in (1, 1, 2))
    assert (first == again).all()
    assert (first != other).any()
    assert first.shape == (256 * (4 if kind == "saltelli" else 1), 2)
    assert ((first[:, 0] >= 2) & (first[:, 0] <= 4)).all()
    assert first[:, 1].mean() == pytest.approx(10, abs=0.1)
    assert first[:, 1].std() == pytest.approx(0.5, rel=0.15)
    assert np.isfinite(first).all()


@pytest.mark.parametrize(
    ("texts", "sample", "count", "message"),
    [
        (["a=1:2"], None, None, "which the grid cannot take"),
        (["a=1:2"], "grid", None, "which the grid cannot take"),
        (["a=1,2"], None, 5, "a grid has all combinations"),
        (["a=1,2"], "lhs", 5, "which the lhs cannot take"),
        (["a=1:2"], "lhs", None, "needs the number of its points"),
        (["a=1:2"], "sobel", 5, "no sample 'sobel'; there are grid, lhs"),
        (["a=1:2:9999", "b=1:2:9999"], None, None, "runs; 5e"),
        (["a=1:2", "b=1:2"], "saltelli", 1 << 25, "saltelli has .* runs; 5e"),
        (["a=1:2", "b=1:2"], "saltelli", 30, "must be a power of 2, such as 32"),
    ],
)
def test_factors_and_samples_that_do_not_fit(
    texts: list[str], sample: str | None, count: int | None, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        designed(texts, sample, count)


def test_points_of_a_dataset() -> None:
    points = xr.Dataset({"a": ("k", [1.0, 2.0]), "b": ("k", [5, 6])})
    assert designed(points)[1] == [[1, 5], [2, 6]]
    crossed = xr.Dataset({"a": ("k", [1.0, 2.0]), "b": ("j", [5.0, 6.0])})
    design, table = designed(crossed)
    assert (design.kind, table) == ("given", [[1, 5], [1, 6], [2, 5], [2, 6]])
    grid = xr.Dataset(coords={"a": [1.0, 2.0], "b": [5.0, 6.0]})
    assert designed(grid)[0].axes == {"a": 2, "b": 2}
    with pytest.raises(InputError, match="leave out sample and count"):
        designed(points, "lhs", 5)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (xr.Dataset(), "no variables"),
        (xr.Dataset({"a": ("k", ["x"])}), "no numbers"),
        (xr.Dataset({"a": ("k", [1.0, np.nan])}), "point 1 is not a finite number"),
        (xr.Dataset({"a": ("k", np.zeros(0))}), "has 0 points"),
        (xr.Dataset({"a": ("k", [1.0, 2.0, 1.0])}), "Point 2 of a is that of an earlier"),
        (xr.Dataset(coords={"a": np.zeros(0)}), "finite numbers, and at least one"),
        (xr.Dataset(coords={"a": [1.0, 2.0, 1.0]}), "a: a value is repeated"),
    ],
)
def test_datasets_that_are_no_points(points: xr.Dataset, message: str) -> None:
    with pytest.raises(InputError, match=message):
        designed(points)


def test_coordinates_beside_variables_are_factors() -> None:
    points = xr.Dataset({"a": ("b", [1.0, 2.0])}, {"b": [0.1, 0.2]})
    design, table = designed(points)
    assert ([*design.factors], table) == (["a", "b"], [[1.0, 0.1], [2.0, 0.2]])
    assert [*designed(points.assign_coords(b=[0, 1]))[0].factors] == ["a"]


def test_points_in_other_units() -> None:
    points = xr.Dataset({"a": ("k", [1000.0, 2000.0], {"units": "mm"}), "b": ("k", [5.0, 6.0])})
    assert designed(points)[1] == [[1.0, 5.0], [2.0, 6.0]]
    with pytest.raises(InputError, match="a: 1 millimeter has the dimension"):
        designed(points, unit="kg")

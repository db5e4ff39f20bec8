"""Factors and designs: what a text means, grids, samples, datasets, and everything that is none."""

import numpy as np
import pytest
import xarray as xr

from codegen.errors import InputError
from runtime.sweeps.design import SAMPLES, design_of, given_design, in_declared_units
from runtime.sweeps.factors import read_factor, read_factors


def test_texts_of_factors() -> None:
    assert read_factor("a", "200:1000:81").values == tuple(np.linspace(200, 1000, 81).tolist())
    assert read_factor("a", "225, 450,900").values == (225.0, 450.0, 900.0)
    assert read_factor("a", "-1e3").values == (-1000.0,)
    for text in ("2:5", "uniform:2:5", ("uniform", 2, 5)):
        factor = read_factor("a", text)
        assert (factor.distribution, factor.bounds) == ("uniform", (2.0, 5.0))
    assert read_factor("a", "normal:450:20").bounds == (450.0, 20.0)
    assert read_factor("a", np.arange(3)).values == (0.0, 1.0, 2.0)
    assert read_factor("a", 4).values == (4.0,)
    assert read_factor("a", "log:1:1000:4").values == pytest.approx((1.0, 10.0, 100.0, 1000.0))
    assert read_factor("a", "3:3:1").values == (3.0,)


def test_texts_with_units() -> None:
    lengths = ["a=100 mm:200 mm:2", "b=normal:20 degC:1 degC", "c=1 m,2 m", "d=5"]
    found = read_factors(lengths)
    assert [factor.unit for factor in found] == ["mm", "degC", "m", ""]
    assert found[0].text == "2 values from 100 to 200 mm"
    design = design_of([found[0], found[2]], None, None, 0)
    metres = in_declared_units(design, lambda name: "m")
    assert metres.points.tolist() == [[0.1, 1.0], [0.1, 2.0], [0.2, 1.0], [0.2, 2.0]]
    with pytest.raises(InputError, match="a: 1 mm has the dimension"):
        in_declared_units(design, lambda name: "kg")


def test_numbers_in_several_units() -> None:
    grid = read_factor("a", "500 mm:2 m:4")
    assert (grid.values, grid.unit) == ((500.0, 1000.0, 1500.0, 2000.0), "mm")
    assert read_factor("a", "500 mm,2 m").values == (500.0, 2000.0)
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
        ("1 mm:2 kg:5", "2 kg has the dimension"),
        ("log:-1:2:5", "equal ratios lead from -1 to 2 by no way"),
        ("log:1:2", "log needs FIRST, LAST and COUNT"),
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
    design = design_of(read_factors(["a=1,2,3", "b=10:20:2"]), None, None, 0)
    assert design.points.tolist() == [[1, 10], [1, 20], [2, 10], [2, 20], [3, 10], [3, 20]]
    assert design.facts["axes"] == {"a": 3, "b": 2}


@pytest.mark.parametrize("kind", SAMPLES)
def test_a_sample_is_that_of_its_seed_and_its_distributions(kind: str) -> None:
    if kind == "saltelli":
        pytest.importorskip("SALib")
    factors = read_factors(["a=2:4", "b=normal:10:0.5"])
    first, again, other = (design_of(factors, kind, 256, seed) for seed in (1, 1, 2))
    assert first.digest == again.digest
    assert first.digest != other.digest
    runs = 256 * (4 if kind == "saltelli" else 1)
    assert first.points.shape == (runs, 2)
    assert ((first.points[:, 0] >= 2) & (first.points[:, 0] <= 4)).all()
    assert first.points[:, 1].mean() == pytest.approx(10, abs=0.1)
    assert first.points[:, 1].std() == pytest.approx(0.5, rel=0.15)
    assert np.isfinite(first.points).all()


@pytest.mark.parametrize(
    ("texts", "sample", "count", "message"),
    [
        (["a=1:2"], None, None, "an interval or a distribution is sampled"),
        (["a=1:2"], "grid", None, "which a grid cannot take"),
        (["a=1,2"], None, 5, "a grid has all combinations"),
        (["a=1,2"], "lhs", 5, "lhs draws from intervals"),
        (["a=1:2"], "lhs", None, "needs the number of its points"),
        (["a=1:2"], "sobel", 5, "no sample 'sobel'; there are grid, lhs"),
        (["a=1:2:9999", "b=1:2:9999"], None, None, "runs; 5e"),
    ],
)
def test_factors_and_samples_that_do_not_fit(
    texts: list[str], sample: str | None, count: int | None, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        design_of(read_factors(texts), sample, count, 0)


def test_points_of_a_dataset() -> None:
    points = xr.Dataset({"a": ("k", [1.0, 2.0]), "b": ("k", [5, 6])})
    assert given_design(points).points.tolist() == [[1, 5], [2, 6]]
    crossed = xr.Dataset({"a": ("k", [1.0, 2.0]), "b": ("j", [5.0, 6.0])})
    assert given_design(crossed).points.tolist() == [[1, 5], [1, 6], [2, 5], [2, 6]]
    grid = xr.Dataset(coords={"a": [1.0, 2.0], "b": [5.0, 6.0]})
    assert given_design(grid).axes == {"a": 2, "b": 2}
    for wrong, message in (
        (xr.Dataset(), "no variables"),
        (xr.Dataset({"a": ("k", ["x"])}), "no numbers"),
        (xr.Dataset({"a": ("k", [1.0, np.nan])}), "point 1 is not a finite number"),
        (xr.Dataset({"a": ("k", np.zeros(0))}), "empty"),
        (xr.Dataset({"a": ("k", [1.0, 2.0, 1.0])}), "Point 2 of a is that of 0"),
        (xr.Dataset(coords={"a": [1.0, 2.0, 1.0]}), "Point 2 of a is that of 0"),
    ):
        with pytest.raises(InputError, match=message):
            given_design(wrong)


def test_coordinates_beside_variables_are_factors() -> None:
    points = xr.Dataset({"a": ("b", [1.0, 2.0])}, {"b": [0.1, 0.2]})
    design = given_design(points)
    assert (design.names, design.points.tolist()) == (("a", "b"), [[1.0, 0.1], [2.0, 0.2]])
    counted = given_design(points.assign_coords(b=[0, 1]))
    assert counted.names == ("a",)


def test_points_in_other_units() -> None:
    points = xr.Dataset({"a": ("k", [1000.0, 2000.0], {"units": "mm"}), "b": ("k", [5.0, 6.0])})
    design = given_design(points)
    found = in_declared_units(design, {"a": "m", "b": "kg"}.__getitem__)
    assert found.points.tolist() == [[1.0, 5.0], [2.0, 6.0]]
    assert found.digest != design.digest
    assert in_declared_units(found, str) is not None
    with pytest.raises(InputError, match="a: 1 mm has the dimension"):
        in_declared_units(design, lambda name: "kg")


def test_runs_of_a_design_of_sobol_count_with_their_factor() -> None:
    with pytest.raises(InputError, match=r"it must lie from 1 to 1\.25e"):
        design_of(read_factors(["a=1:2", "b=1:2"]), "saltelli", 1 << 25, 0)

"""Figures of declarations, states and results: what stands in them, and what is refused."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.figure import Figure

from codegen import Model
from codegen.drawing.matplotlib_painter import figure
from codegen.errors import InputError
from codegen.picture_at_start import declared_picture
from codegen.reading.model_file import read_model
from runtime import load
from runtime.machine_facade import Machine
from runtime.show.pictures import draw_result


@pytest.fixture(scope="module")
def machine() -> Machine:
    return load("slider_crank", "compressor")


@pytest.fixture(scope="module")
def result(machine: Machine) -> Any:
    return machine.simulate(0.5, 51, progress=False)


def texts(figure: Figure) -> set[str]:
    return {t.get_text() for axes in figure.axes for t in axes.texts if t.get_visible()}


def corners(figure: Figure) -> np.ndarray:
    """All corners of lines and polygons, in data coordinates."""
    lines = [c for axes in figure.axes for c in axes.collections]
    return np.concatenate([path.vertices for one in lines for path in one.get_paths()])


def test_a_declaration_names_its_bodies_and_joints() -> None:
    figure = read_model("slider_crank").model.draw("kinematics")
    assert {"crank", "rod", "slider", "A", "B", "C", "guide"} <= texts(figure)
    assert figure.axes[0].get_aspect() == 1.0
    bare = read_model("slider_crank").model.draw("kinematics", names=False)
    assert not {"crank", "B"} & texts(bare)


@pytest.mark.parametrize(
    ("length", "assembled", "gap"),
    [(3.0, False, "B: 0.25 m apart"), (3.0, True, ""), (0.5, True, "m apart")],
)
def test_guesses_that_leave_joints_open_say_how_far(
    length: float, assembled: bool, gap: str
) -> None:
    model = read_model("slider_crank").model
    drawn = model.draw("kinematics", parameters={"rod_length": length}, assembled=assembled)
    gaps = [text for text in texts(drawn) if "apart" in text]
    assert any(gap in text for text in gaps) if gap else not gaps
    assert ("its joints do not close" in drawn.axes[0].get_title()) is (length < 1.0)


def test_dimensions_are_distances_of_the_places_of_a_body(machine: Machine) -> None:
    assert {"2", "3.5"} <= texts(machine.draw(dimensions=True))
    longer = machine.draw(parameters={"rod_length": 4.2}, dimensions=True)
    assert {"2", "4.2"} <= texts(longer)


def test_a_state_is_drawn_where_it_is(machine: Machine, result: Any) -> None:
    at = result.state(0.3)
    for drawn in (machine.draw(at), result.draw(0.3)):
        points = corners(drawn)
        pin = 2 * np.array([np.cos(at["crank.phi"]), np.sin(at["crank.phi"])])
        assert np.hypot(*(points - pin).T).min() < 0.2
        assert points[:, 0].max() > at["slider.x"]


def test_an_instant_puts_drivers_where_they_are_then() -> None:
    driven = load("slider_crank", "kinematics")
    angle = 0.75 * np.pi  # π/4 at the start, a quarter of a turn on
    pin = 2 * np.array([np.cos(angle), np.sin(angle)])
    assert np.hypot(*(corners(driven.draw(0.25)) - pin).T).min() < 0.2
    assert np.hypot(*(corners(driven.draw()) - pin).T).min() > 0.5


def test_reactions_are_drawn_with_their_sizes(result: Any) -> None:
    with_forces = texts(result.draw(0.3, forces=True))
    size = np.hypot(result.at(0.3).reaction("B", "fx"), result.at(0.3).reaction("B", "fy"))[0]
    assert f"B, crank on rod: {size / 1e3:.3g} kN" in with_forces
    assert not any(text.startswith("B, crank") for text in texts(result.draw(0.3)))


def test_a_body_that_exerts_a_force_has_the_opposite_arrow() -> None:
    model = Model("pair")
    first, second = (model.body(name, mass=1.0, inertia=1.0) for name in ("first", "second"))
    model.force("push", on=second.at(0.2, 0.1), fx=3.0, fy=4.0, from_=first)
    model.torque("motor", on=second, value=2.0, from_=first)
    places = {"first.x": 1.0, "first.y": 2.0, "first.phi": 0.5, "second.x": 3.0, "second.y": 1.0}
    model.scene("free", ["push", "motor"], guess={**places, "second.phi": -0.3})
    picture = declared_picture(model)
    force, opposite = (s.shape for s in picture.symbols if s.element == "push")
    assert (opposite.fx, opposite.fy) == (-3.0, -4.0)
    assert picture.at(opposite.at) == pytest.approx(picture.at(force.at))
    turned = [s.shape for s in picture.symbols if s.element == "motor"]
    assert [(shape.at.body, shape.torque) for shape in turned] == [(2, 2.0), (1, -2.0)]
    assert {"push on first: 5 N", "push on second: 5 N"} <= texts(figure(picture, forces=True))


def test_a_figure_for_a_file_is_not_in_pyplot(result: Any) -> None:
    draw_result(result, 0.1)
    assert not plt.get_fignums()


@pytest.mark.parametrize(
    ("arguments", "words", "message"),
    [
        (("nowhere",), {}, "has no scene 'nowhere'"),
        ((), {"parameters": {"J9": 1.0}}, "no parameter 'J9'"),
        ((), {"parameters": 70}, "parameters is 70; it must be a mapping"),
        ((), {"dimensions": "yes"}, "dimensions is 'yes'"),
        ((3,), {}, "scene is 3"),
    ],
)
def test_what_a_declaration_does_not_draw(arguments: Any, words: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_model("slider_crank").model.draw(*arguments, **words)


def test_what_machines_and_results_do_not_draw(machine: Machine, result: Any) -> None:
    with pytest.raises(InputError, match="at is nan"):
        machine.draw(float("nan"))
    with pytest.raises(InputError, match="at is 'here'; it must be an instant in s, or a state"):
        machine.draw("here")  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"t = 7 s lies outside"):
        result.draw(7.0)
    with pytest.raises(InputError, match=r"frames is 1\.5"):
        result.draw(0.1, frames=1.5)

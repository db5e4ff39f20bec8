"""Results, machines, scenes, coordinates and events show themselves: names, numbers, units."""

import pytest

from codegen import Model
from codegen.declare.symbols import Velocity
from runtime.machine_facade import Machine
from runtime.results.event_records import Event, SingularPosition


def test_result(driven: Machine) -> None:
    run = driven.inverse_dynamics([0.0, 0.5, 1.0])
    lines = repr(run).splitlines()
    assert lines[0] == "sc_driven/driven, inverse dynamics: 3 instants, t = 0 to 1 s"
    assert lines[1].startswith("  OK: ")
    assert lines[2].startswith("  coordinates  crank.x (m), crank.y (m), crank.phi (rad), ")
    assert lines[3].startswith("  reactions    ")
    assert lines[3].endswith(" (N, N m)")
    html = run._repr_html_()
    assert html.startswith("<div><p><b>sc_driven/driven, inverse dynamics")
    assert "<td>crank.phi</td><td>rad</td>" in html
    assert f"<td style='text-align:right'>{run.q('crank.phi')[-1]:.6g}</td>" in html
    assert html.count("<tr>") == 1 + len(driven.coordinates)
    assert "\n".join(lines[:2]) == run.headline


def test_equilibrium(pendulum: Machine) -> None:
    rest = pendulum.equilibrium()
    assert repr(rest).splitlines()[-1] == ("  equilibrium  stable; natural frequencies 0.445861 Hz")
    assert "natural frequencies 0.445861 Hz" in rest._repr_html_()


def test_assembly(pendulum: Machine) -> None:
    state = pendulum.assemble(start={"bar.phi": 0.25})
    lines = repr(state).splitlines()
    assert lines[0].startswith("Assembled at t = 0 s, degrees of freedom: 1")
    assert "bar.phi = 0.25 rad" in lines[-2]
    assert "bar.omega = " in lines[-1]
    assert "rad/s" in lines[-1]
    assert "array" not in repr(state)
    assert "<td>bar.phi</td>" in state._repr_html_()


def test_machine_and_its_tables(driven: Machine) -> None:
    assert "<th style='text-align:left'>parameter</th>" in driven._repr_html_()
    lines = repr(driven.coordinates).splitlines()
    assert lines[0].split() == ["name", "velocity", "unit"]
    assert lines[1].split() == ["crank.x", "crank.vx", "m"]
    assert len(lines) == 1 + len(driven.coordinates)
    html = driven.coordinates._repr_html_()
    assert "<td>crank.vx</td>" in html
    assert repr(type(driven.coordinates)()) == "no rows"
    assert type(driven.coordinates)()._repr_html_() == "<p>no rows</p>"


def test_event_and_singular_position() -> None:
    event = Event("plate: ball_y > 0", 0.451523641, 2, None, None)  # type: ignore[arg-type]
    assert repr(event) == "Event at t = 0.451523641 s: plate: ball_y > 0, impact"
    met = SingularPosition("crossing", 1.5, ("drive",), ("A",), 1, ({"crank.phi": 1.0},), 0.0, 0.0)
    assert repr(met) == (
        "SingularPosition, crossing, at t = 1.5 s: singular: drive, A; free crank.phi +1"
    )


@pytest.fixture
def model() -> Model:
    made = Model("stone", gravity=(0, -9.81))
    stone = made.body("stone", mass=2.0, inertia=1.0)
    made.force("wind", on=stone, fx=4.0)
    made.scene("windy", effects=["wind", "gravity"], start={stone.x: 1.0})
    return made


def test_scene(model: Model) -> None:
    scene = model.scenes["windy"]
    assert repr(scene) == (
        "Scene 'windy' of stone, dynamics: effects gravity, wind; drivers none"
    ) or repr(scene) == ("Scene 'windy' of stone, dynamics: effects wind, gravity; drivers none")
    assert "start       stone_x = 1" in scene._repr_html_() or "stone.x = 1" in scene._repr_html_()


class Printer:
    def __init__(self) -> None:
        self.said = ""

    def text(self, words: str) -> None:
        self.said += words


def test_coordinate_and_velocity(model: Model) -> None:
    """As objects of their own; in expressions SymPy prints names."""
    phi = model.bodies["stone"].phi
    printer = Printer()
    phi._repr_pretty_(printer, False)
    assert printer.said == "stone_phi (rad), rate stone_omega"
    assert phi._repr_latex_() == (
        r"$\displaystyle stone_{\phi}\ [\mathrm{rad}]\quad \text{rate } stone_{\omega}$"
    )
    assert isinstance(phi.rate, Velocity)
    assert phi.rate._repr_latex_() == r"$\displaystyle stone_{\omega}\ [\mathrm{rad/s}]$"
    assert str(2 * phi) == "2*stone_phi"

"""Results, machines, scenes, coordinates and events show themselves: names, numbers, units."""

from pathlib import Path

import numpy as np
import pytest

from codegen import Model
from codegen.declare.symbols import Velocity
from runtime import load, matters
from runtime.machine_facade import Machine
from runtime.results.run_records import Event, SingularPosition


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


def test_reached_accuracy(pendulum: Machine) -> None:
    run = pendulum.simulate(0.5, accuracy=1e-4, start={"bar.phi": 0.25})
    lines = repr(run.accuracy).splitlines()
    assert lines[0].startswith("Global error estimated as about ")
    assert lines[1].startswith("  Estimated from the difference of two runs, ")
    assert lines[2].startswith("  Cost: ")


def test_assembly(pendulum: Machine) -> None:
    state = pendulum.assemble(start={"bar.phi": 0.25})
    lines = repr(state).splitlines()
    assert lines[0].startswith("Assembled at t = 0 s, degrees of freedom: 1")
    assert "bar.phi = 0.25 rad" in lines[-2]
    assert "bar.omega = " in lines[-1]
    assert "rad/s" in lines[-1]
    assert "array" not in repr(state)
    assert "<td>bar.phi</td>" in state._repr_html_()


def test_state(pendulum: Machine) -> None:
    text = repr(pendulum.simulate(0.1, start={"bar.phi": 0.25, "bar.omega": 0.5}).state(0.0))
    assert text.startswith("State at t = 0 s: bar.x = ")
    assert ", bar.phi = 0.25 rad, bar.vx = " in text
    assert text.endswith(", bar.omega = 0.5 rad/s")
    assert "array" not in text


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


@pytest.fixture
def pointed() -> Model:
    made = Model("pointed", gravity=(0, -9.81))
    made.parameter("m", 2.0, "kg", sign="positive")
    stone = made.body("stone", mass=2.0, inertia=1.0)
    made.track("tip", stone.at(1, 0))
    made.force("wind", on=stone, fx=4.0)
    made.scene("windy", ["wind"], start={stone.x: 1.0}, outputs=["default", "points", "forces"])
    made.scene("calm", start={stone.x: 1.0})
    return made


def test_points_have_their_own_place(pointed: Model, tmp_path: Path) -> None:
    """They act on nothing, and are no effects, in scenes, machines and tables."""
    windy = pointed.scenes["windy"]
    assert repr(windy).endswith("effects wind; drivers none")
    assert "  acting      wind\n" in str(windy)
    assert "  points      tip\n" in str(windy)
    machine = load(pointed, "windy", folder=tmp_path)
    assert machine.effects.names == ("wind",)
    pointed.scene("plain", ["gravity", "wind"], start={pointed.bodies["stone"].x: 1.0})
    shown = repr(load(pointed, "plain", folder=tmp_path).simulate(0.1))
    assert "  effects      gravity, wind" in shown.splitlines()  # those that act, as of the machine
    assert "  points      tip" in repr(machine)
    calm = load(pointed, "calm", folder=tmp_path)
    assert "  left out    gravity, wind" in repr(calm).splitlines()


def test_what_a_scene_reports_is_not_said_to_be_all(pointed: Model) -> None:
    assert "  reported    reactions, energy, powers" in str(pointed.scenes["calm"]).splitlines()


def test_model(pointed: Model) -> None:
    html = pointed._repr_html_()
    assert "<b>Model &#x27;pointed&#x27;</b><br>bodies stone<br>effects gravity, wind<br>" in html
    assert "<br>points tip<br>scenes windy, calm</p>" in html
    assert "<td>m</td><td style='text-align:right'>2</td><td>kg</td>" in html
    lines = str(pointed).splitlines()
    assert lines[:3] == ["Model 'pointed'", "bodies stone", "effects gravity, wind"]


def test_ranking(pointed: Model, tmp_path: Path) -> None:
    scene = pointed.scenes["windy"].with_("gravity")
    found = matters(pointed, scene, asked="stone.x", t_end=1.0, folder=tmp_path)
    first, *rest = repr(found).splitlines()
    assert first.endswith(", simulate: stone.x = 2 m")
    assert any("wind changes stone.x by 50 %" in line for line in rest), rest
    html = found._repr_html_()
    assert "<td>wind</td>" in html
    assert "matters</td>" in html


def test_zero_has_no_sign(tmp_path: Path) -> None:
    """A contact that is open pushes with 0 N, and not with -0 N."""
    made = Model("open_contact", gravity=(0, -9.81))
    ball = made.particle("ball", 1.0)
    made.contact("floor", gap=ball.y, stiffness=1e4)
    start = {ball.x: 0.0, ball.y: 1.0, ball.vx: 0.0, ball.vy: 0.0}
    made.scene("fall", ["gravity", "floor"], start=start, outputs="all")
    r = load(made, folder=tmp_path).simulate(0.1, 3)
    for values in (r.force("floor"), r.penetration("floor"), r.power("floor"), r.power("gravity")):
        assert not np.signbit(values[values == 0.0]).any()
    assert (r.force("floor") == 0.0).all()


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

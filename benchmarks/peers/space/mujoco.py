"""MuJoCo in space: trees of hinges, loops closed by soft `connect`, springs as tendons.

A hinge that closes a loop is held at two points of its axis. Of its integrators the Runge-Kutta
method reaches the least errors.
"""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from benchmarks.peers.mujoco import stepped
from benchmarks.peers.protocol import main
from benchmarks.problems import Problem
from benchmarks.space_machines import ARM, BRICARD, Chain, Platform, SliderCrank

HEAD = (
    '<mujoco><compiler angle="radian"/><option timestep="{{step!r}}" integrator="RK4" '
    'gravity="{gravity}" tolerance="1e-14" iterations="2" jacobian="dense">'
    '<flag contact="disable"/></option>'
)
HARD = 'solref="{decay!r} 1" solimp="0.9999 0.9999 0.001 0.5 2"'


def text(values: Any) -> str:
    """Numbers with all digits."""
    return " ".join(repr(float(x)) for x in values)


def inside(at: Any, origin: Any) -> str:
    """A place relative to another."""
    return text(np.subtract(at, origin))


def head(gravity: Sequence[float]) -> str:
    """The options; step and decay stay open."""
    return HEAD.format(gravity=text(gravity))


def solved(problem: Problem, xml: str, body: str, prepare: Any, first: int) -> None:
    """All steps; the answer is a body's centre of mass."""
    model = mujoco.MjModel.from_xml_string(xml.format(step=0.001, decay=0.002))
    number, data = model.body(body).id, mujoco.MjData(model)

    def centre(q: Any) -> Any:
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        return data.xipos[number]

    stepped(problem, xml, prepare, centre, first)


def chained(problem: Problem, chain: Chain, body: str, first: int) -> None:
    """Links one in the other, and the hinge that closes them."""
    inner, origins = "", [(0.0, 0.0, 0.0), *(link.hinge for link in chain.links)]
    for k, link in reversed(list(enumerate(chain.links))):
        inner = (
            f'<body name="{link.name}" pos="{inside(link.hinge, origins[k])}">'
            f'<joint type="hinge" axis="{text(link.axis)}"/>'
            f'<inertial pos="{inside(link.centre, link.hinge)}" mass="{link.mass!r}" '
            f'diaginertia="{text(link.moments)}"/>{inner}</body>'
        )
    held = ""
    if chain.closing:
        at, axis = chain.closing
        for point in (at, np.add(at, axis)):
            anchor = inside(point, origins[-1])
            held += f'<connect body1="{chain.links[-1].name}" anchor="{anchor}" {HARD}/>'
    xml = f"{head(chain.gravity)}<worldbody>{inner}</worldbody><equality>{held}</equality></mujoco>"
    solved(problem, xml, body, lambda data: None, first)


def crank(problem: Problem) -> None:
    """The rod turns on the slider, and its other end is held at the crank's pin."""
    s = SliderCrank
    inertia = np.array(s.rod_inertia())[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    xml = f"""{head(s.gravity)}
  <worldbody>
    <body name="slider" pos="{text(s.C)}">
      <joint type="slide" axis="1 0 0"/>
      <inertial pos="0 0 0" mass="{s.slider[0]}" diaginertia="{text(s.slider[1])}"/>
      <body name="rod">
        <joint type="hinge" axis="1 0 0"/>
        <joint type="hinge" axis="{text(s.across)}"/>
        <inertial pos="{inside(s.middle, s.C)}" mass="{s.rod[0]}" fullinertia="{text(inertia)}"/>
      </body>
    </body>
    <body name="crank" pos="{text(s.A)}">
      <joint type="hinge" axis="1 0 0"/>
      <inertial pos="0 0 0" mass="{s.crank[0]}" diaginertia="{text(s.crank[1])}"/>
    </body>
  </worldbody>
  <equality><connect body1="rod" body2="crank" anchor="{inside(s.B, s.C)}" {HARD}/></equality>
</mujoco>"""

    def prepare(data: Any) -> None:
        data.qvel[:] = s.rates

    solved(problem, xml, "rod", prepare, 2000)


def platform(problem: Problem) -> None:
    """A free body on tendons."""
    p = Platform
    ground = plate = tendons = ""
    for k, (base, on) in enumerate(p.legs()):
        ground += f'<site name="base{k}" pos="{text(base)}"/>'
        plate += f'<site name="on{k}" pos="{text(on)}"/>'
        tendons += (
            f'<spatial stiffness="{p.stiffness!r}" springlength="{p.rest!r}">'
            f'<site site="base{k}"/><site site="on{k}"/></spatial>'
        )
    xml = (
        f'{head(p.gravity)}<worldbody>{ground}<body name="plate" pos="{text((0, 0, p.height))}">'
        f'<freejoint/><inertial pos="0 0 0" mass="{p.mass}" diaginertia="{text(p.moments)}"/>'
        f"{plate}</body></worldbody><tendon>{tendons}</tendon></mujoco>"
    )

    def prepare(data: Any) -> None:
        data.qpos[:] = *p.place, *p.attitude

    solved(problem, xml, "plate", prepare, 400)


SOLVERS = {
    "bricard": lambda problem: chained(problem, BRICARD, "b3", 1000),
    "spatial_slider_crank": crank,
    "stewart_platform": platform,
    "six_revolute_arm": lambda problem: chained(problem, ARM, "tool", 400),
}

if __name__ == "__main__":
    main(["mujoco"], SOLVERS)

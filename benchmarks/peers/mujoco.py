"""MuJoCo: its Runge-Kutta over steps; a loop is a soft `connect`, as stiff as steps allow.

MuJoCo has no rigid constraint. `solref` is the time in which a violation is to decay, and may not
be shorter than two steps; `solimp` takes it as hard as its regularisation can.
"""

from typing import Any

import mujoco
import numpy as np

from benchmarks.floor import slider_crank
from benchmarks.peers.protocol import main, point
from benchmarks.problems import GRAVITY, Problem

LONGEST = 3_000.0
"""Milliseconds of a run after which the step is not halved again."""


def stepped(problem: Problem, text: str, prepare: Any, angles: Any, first: int) -> None:
    """Fourth order Runge-Kutta, halving the step from the duration's `first` part on."""
    for doubling in range(12):
        steps = first * 2**doubling
        h = problem.duration / steps
        model = mujoco.MjModel.from_xml_string(text.format(step=h, decay=2.0 * h))
        data = mujoco.MjData(model)

        def run(model: Any = model, data: Any = data, steps: int = steps) -> Any:
            mujoco.mj_resetData(model, data)
            prepare(data)
            mujoco.mj_step(model, data, nstep=steps)
            return data.qpos.copy()

        made = point(problem, "mujoco", "RK4", h, run, lambda out, n=steps: 4 * n, angles)
        if made.milliseconds > LONGEST / 2.0:
            break


CRANK = f"""
<mujoco>
  <compiler angle="radian"/>
  <option timestep="{{step!r}}" integrator="RK4" gravity="{GRAVITY} 0 0" tolerance="1e-14"
          iterations="2" jacobian="dense"><flag contact="disable" warmstart="enable"/></option>
  <worldbody>
    <body name="crank" pos="0 0 0">
      <joint type="hinge" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="200" diaginertia="450 450 450"/>
      <body name="rod" pos="2 0 0">
        <joint type="hinge" axis="0 0 1"/>
        <inertial pos="1.75 0 0" mass="35" diaginertia="35 35 35"/>
      </body>
    </body>
    <body name="slider" pos="5.5 0 0">
      <joint type="slide" axis="1 0 0"/>
      <inertial pos="0 0 0" mass="25" diaginertia="0.02 0.02 0.02"/>
    </body>
  </worldbody>
  <equality>
    <connect body1="rod" body2="slider" anchor="3.5 0 0" solref="{{decay!r}} 1"
             solimp="0.9999 0.9999 0.001 0.5 2"/>
  </equality>
</mujoco>
"""


def crank(problem: Problem) -> None:
    """The closed loop; the model is drawn at φ = 0, where the slider is at x = 5.5."""
    phi, omega = slider_crank.START

    def prepare(data: Any) -> None:
        data.qpos[:] = phi, -phi, 1.5 - 5.5
        data.qvel[:] = omega, 2.0 * omega / 3.5 - omega, 0.0
        data.qfrc_applied[0] = slider_crank.PARAMETERS[1]

    stepped(problem, CRANK, prepare, lambda out: out[:1], 2000)


def chain(problem: Problem) -> None:
    """The tree, which needs no constraint."""
    links = len(problem.reference)
    inner = ""
    for k in reversed(range(links)):
        inner = (
            f'<body pos="{float(k > 0)} 0 0"><joint type="hinge" axis="0 0 1"/><inertial '
            f'pos="0.5 0 0" mass="1" diaginertia="{1 / 12!r} {1 / 12!r} {1 / 12!r}"/>{inner}</body>'
        )
    text = (
        '<mujoco><compiler angle="radian"/><option timestep="{step!r}" integrator="RK4" '
        f'gravity="0 -{GRAVITY} 0"><flag contact="disable"/></option>'
        f"<worldbody>{inner}</worldbody></mujoco>"
    )
    stepped(problem, text, lambda data: None, np.cumsum, 200)


if __name__ == "__main__":
    main(["mujoco"], {"slider_crank": crank, "chain_10": chain, "chain_100": chain})

"""A robot arm with three revolute joints, and four ways to control it.

                             o tip
                           /
                  E o----o W       upper arm 0.8 m, forearm 0.6 m, hand 0.3 m
                  /
                /
           S  o
             ///

The shoulder S is on the ground. Motors in the joints turn each link against the one before it, by
PD control of the joint angles towards a target, so that the reaction of the elbow's motor acts on
the upper arm. The motor's torques are limited where the control is sampled. Dimensions, masses and
gains are those of no arm in particular (C).

Scenes
------
continuous
    PD control without a clock.
sampled
    PD control sampled at 1 kHz, with torques that saturate.
own
    The same clock; the torques are what a function of the user's answers,
    ``simulate(controllers={"own_shoulder": ..., "own_elbow": ..., "own_wrist": ...})``.
integral
    PD control with the integral of the error, a state of first order, which gravity does not move
    from its target.
"""

from sympy import Max, Min

from codegen import Model, disc, rectangle

model = Model("robot_arm", gravity=(0, -9.81))

# Parameters may change from run to run without a new build.
payload = model.parameter("payload", 1.0, unit="kg", sign="nonnegative")

# Uniform rods, centres of mass in the middle and x' along the link; the payload is at the tip.
ends = [disc(0.1, (-0.4, 0)), disc(0.08, (0.4, 0))]
upper = model.body("upper", mass=4.0, inertia=0.22, draw=[*ends, rectangle(0.8, 0.12)])
ends = [disc(0.07, (-0.3, 0)), disc(0.06, (0.3, 0))]
fore = model.body("fore", mass=2.5, inertia=0.08, draw=[*ends, rectangle(0.6, 0.09)])
palm = [rectangle(0.23, 0.07, (-0.06, 0)), rectangle(0.03, 0.17, (0.06, 0))]
fingers = [rectangle(0.15, 0.03, (0.14, y)) for y in (-0.07, 0.07)]
hand = model.body("hand", mass=1.0, inertia=0.01, draw=[*palm, *fingers])
load = model.particle("load", mass=payload, draw=rectangle(0.1, 0.1))

model.revolute("shoulder", model.ground.at(0, 0), upper.at(-0.4, 0))
model.revolute("elbow", upper.at(0.4, 0), fore.at(-0.3, 0))
model.revolute("wrist", fore.at(0.3, 0), hand.at(-0.15, 0))
model.revolute("grip", hand.at(0.15, 0), load.at(0, 0))

# Joint: its links, target in rad, gains of angle, rate and integral, and the motor's limit in N m.
joints = {
    "shoulder": (model.ground, upper, 0.9, 400.0, 60.0, 600.0, 90.0),
    "elbow": (upper, fore, 0.7, 200.0, 20.0, 300.0, 40.0),
    "wrist": (fore, hand, -0.5, 60.0, 3.0, 100.0, 12.0),
}
scenes = ("continuous", "sampled", "own", "integral")
for name, (base, link, target, kp, kd, ki, limit) in joints.items():
    error = target - (link.phi - base.phi)
    pd = kp * error - kd * (link.omega - base.omega)
    saturated = Max(-limit, Min(limit, pd))
    torques = (
        pd,
        model.sampled(f"u_{name}", every=0.001, value=saturated, unit="N m", nominal=limit),
        model.sampled(f"own_{name}", every=0.001, unit="N m", nominal=limit),
        pd + ki * model.state(f"sum_{name}", rate=error, unit="rad s"),
    )
    for scene, torque in zip(scenes, torques, strict=True):
        model.torque(f"{scene}_{name}_motor", on=link, from_=base, value=torque)

# Hanging down at rest.
hanging = {upper.phi: -1.4, fore.phi: -1.5, hand.phi: -1.6, upper.omega: 0.0, fore.omega: 0.0,
           hand.omega: 0.0}  # fmt: skip

for scene in scenes:
    motors = [f"{scene}_{name}_motor" for name in joints]
    model.scene(scene, ["gravity", *motors], start=hanging)

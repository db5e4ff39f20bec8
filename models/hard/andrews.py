"""Andrews' squeezing mechanism: seven bodies in three loops, the fast ones and the slow in one.

The benchmark of W. Schiehlen, *Multibody Systems Handbook* (1990), and of E. Hairer and G. Wanner,
*Solving Ordinary Differential Equations II*, section VII.7; also problem A03 of the IFToMM
library of multibody benchmarks. A motor drives the crank K1 about O; its rod K2 ends in F, where it
meets the three-point link K3, which turns about B and is held by a spring to C, and the two chains
K5-K4 and K7-K6, which turn about A:

      C ~~~~ o
              `.K3 . B
                F'          E   O
     K4 .  `.  o -- K2 ---- o--o  K1
      G o       | K6
       K5 `.    o H
            A -' K7

Within 0.05 s the crank turns five times and more, up to 1140 rad/s, while the others swing; the
slowest turns at a few rad/s. Frames lie in the centres of mass and turn with the angles of the
benchmark: β, β + Θ, γ, Φ + δ, δ, Ω + ε, ε.

Scenes
------
released
    From rest at β = -0.0620 rad, under the motor's constant torque and the spring.
"""

from codegen import Model

model = Model("andrews")

torque = model.parameter("torque", 0.033, unit="N m")

ra, rr = 0.00092, 0.007
da, d = 0.0115, 0.028
sa, sb, sc, sd, ss = 0.01874, 0.01043, 0.018, 0.02, 0.035
ea, e = 0.01421, 0.02
ta, tb, zt = 0.02308, 0.00916, 0.04
fa, zf = 0.01421, 0.02
ua, ub, u = 0.01228, 0.00449, 0.04

ground = model.ground
A, B, C = ground.at(-0.06934, -0.00227), ground.at(-0.03635, 0.03273), ground.at(0.014, 0.072)

K1 = model.body("K1", mass=0.04325, inertia=2.194e-6)
K2 = model.body("K2", mass=0.00365, inertia=4.410e-7)
K3 = model.body("K3", mass=0.02373, inertia=5.255e-6)
K4 = model.body("K4", mass=0.00706, inertia=5.667e-7)
K5 = model.body("K5", mass=0.07050, inertia=1.169e-5)
K6 = model.body("K6", mass=0.00706, inertia=5.667e-7)
K7 = model.body("K7", mass=0.05498, inertia=1.912e-5)

model.revolute("O", ground.at(0, 0), K1.at(-ra, 0))
model.revolute("E", K1.at(rr - ra, 0), K2.at(da, 0))
model.revolute("B", B, K3.at(-sb, sa))
model.revolute("A5", A, K5.at(-ta, -tb))
model.revolute("G", K5.at(zt - ta, -tb), K4.at(0, e - ea))
model.revolute("A7", A, K7.at(ub, ua))
model.revolute("H", K7.at(ub, ua - u), K6.at(fa - zf, 0))

# All chains meet at F, the far end of K2.
F = K2.at(da - d, 0)
model.revolute("F3", F, K3.at(-sb, sa - ss))
model.revolute("F4", F, K4.at(0, -ea))
model.revolute("F6", F, K6.at(fa, 0))

model.spring("spring", C, K3.at(sd - sb, sa - sc), stiffness=4530.0, free_length=0.07785)
model.torque("motor", on=K1, value=torque)

# About where the benchmark's figure shows the bodies.
drawn = {
    K1.x: 0.0009, K2.x: -0.0045, K2.phi: -0.06, K3.x: -0.0187, K3.y: 0.0205, K3.phi: 0.46,
    K4.x: -0.0302, K4.y: 0.0121, K4.phi: 0.71, K5.x: -0.0532, K5.y: 0.0166, K5.phi: 0.49,
    K6.x: -0.0285, K6.y: -0.0107, K6.phi: 1.01, K7.x: -0.0593, K7.y: -0.0106, K7.phi: 1.23,
}  # fmt: skip

model.scene("released", ["spring", "motor"], start={K1.phi: -0.0620, K1.omega: 0.0}, guess=drawn)

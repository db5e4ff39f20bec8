"""Exudyn: bodies of three coordinates with joints by the generalized-α method, chains as trees too.

Its explicit methods take no joints, so that loops go with the implicit ones: index 3 by the
generalized-α method of spectral radius 0.9, and index 2 by its trapezoidal rule. A chain without
loops is a kinematic tree in its joints' angles, solved by DOPRI5 and by Runge-Kutta of order 7.
Files, sensors and messages are off, Newton's matrix is kept (modified Newton), and the matrices are
dense where they are small and sparse in the long mechanism.
"""

import math
from typing import Any

import exudyn as exu
import numpy as np
from exudyn.itemInterface import (
    Force,
    MarkerBodyPosition,
    MarkerBodyRigid,
    NodeGenericODE2,
    NodeRigidBody2D,
    ObjectConnectorSpringDamper,
    ObjectGround,
    ObjectJointPrismatic2D,
    ObjectJointRevolute2D,
    ObjectKinematicTree,
    ObjectRigidBody2D,
    Torque,
)

from benchmarks.floor import andrews, slider_crank
from benchmarks.peers.protocol import TOLERANCES, main, sweep
from benchmarks.problems import GRAVITY, Problem

Vector = tuple[float, float]


class Machine:
    """A system of plane bodies that is put together joint by joint."""

    def __init__(self, gravity: Vector) -> None:
        self.container = exu.SystemContainer()
        self.system = self.container.AddSystem()
        self.gravity = gravity
        self.ground = self.system.AddObject(ObjectGround())
        self.nodes: list[Any] = []

    def body(self, mass: float, inertia: float, at: Any, rate: Any = (0.0, 0.0, 0.0)) -> Any:
        """A body with its centre of mass at (x, y, φ) and a start velocity; its object."""
        node = self.system.AddNode(
            NodeRigidBody2D(
                referenceCoordinates=[0.0, 0.0, 0.0],
                initialCoordinates=list(map(float, at)),
                initialVelocities=list(map(float, rate)),
            )
        )
        self.nodes.append(node)
        made = self.system.AddObject(ObjectRigidBody2D(nodeNumber=node, mass=mass, inertia=inertia))
        if any(self.gravity):
            pull = [mass * self.gravity[0], mass * self.gravity[1], 0.0]
            centre = self.system.AddMarker(MarkerBodyPosition(bodyNumber=made))
            self.system.AddLoad(Force(markerNumber=centre, loadVector=pull))
        return made

    def point(self, body: Any, at: Vector) -> Any:
        """A marker at a point of a body, in the body's axes."""
        return self.system.AddMarker(
            MarkerBodyPosition(bodyNumber=body, localPosition=[at[0], at[1], 0.0])
        )

    def hinge(self, one: Any, at: Vector, other: Any, there: Vector) -> None:
        """A revolute joint."""
        markers = [self.point(one, at), self.point(other, there)]
        self.system.AddObject(ObjectJointRevolute2D(markerNumbers=markers))

    def torque(self, body: Any, value: float) -> None:
        """A constant torque."""
        marker = self.system.AddMarker(MarkerBodyRigid(bodyNumber=body))
        self.system.AddLoad(Torque(markerNumber=marker, loadVector=[0.0, 0.0, value]))

    def angles(self, count: int) -> list[float]:
        """Those of the first bodies."""
        kind = exu.OutputVariableType.Coordinates
        return [float(self.system.GetNodeOutput(n, kind)[2]) for n in self.nodes[:count]]


def settings(duration: float, steps: int, sparse: bool, newton: float = 1e-8) -> Any:
    """What all runs have in common."""
    made = exu.SimulationSettings()
    made.timeIntegration.endTime = duration
    made.timeIntegration.numberOfSteps = steps
    made.timeIntegration.verboseMode = 0
    made.timeIntegration.newton.useModifiedNewton = True
    made.timeIntegration.newton.relativeTolerance = newton
    made.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    made.solution.file.write = False
    made.solution.file.information = ""
    made.show.statistics = False
    made.show.computationTime = False
    made.linearSolver.solverType = (
        exu.LinearSolverType.EigenSparse if sparse else exu.LinearSolverType.EXUdense
    )
    made.parallel.numberOfThreads = 1
    return made


IMPLICIT = {
    "generalized-α": exu.DynamicSolverType.GeneralizedAlpha,
    "trapezoidal, index 2": exu.DynamicSolverType.TrapezoidalIndex2,
}


def halved(
    problem: Problem, machine: Machine, first: int, sparse: bool = False, newton: float = 1e-10
) -> None:
    """The implicit methods over steps."""
    machine.system.Assemble()
    for method, kind in IMPLICIT.items():

        def run(h: float, kind: Any = kind) -> list[float]:
            steps = round(problem.duration / h)
            made = settings(problem.duration, steps, sparse, newton)
            if not machine.system.SolveDynamic(made, solverType=kind, updateInitialValues=False):
                raise RuntimeError("the solver gave up")
            return machine.angles(1)

        steps = [problem.duration / (first * 2**k) for k in range(9)]
        sweep(problem, "exudyn", method, steps, run)


def crank(problem: Problem) -> None:
    """The slider on the x axis by the same joint as its height, one coordinate on the ground."""
    machine = Machine((GRAVITY, 0.0))
    phi, omega = slider_crank.START
    turn = 2.0 * omega / 3.5
    turned = machine.body(200.0, 450.0, (0.0, 0.0, phi), (0.0, 0.0, omega))
    rod = machine.body(35.0, 35.0, (-0.25, 0.0, 0.0), (0.0, -omega, turn))
    slider = machine.body(25.0, 0.02, (1.5, 0.0, 0.0))
    machine.hinge(machine.ground, (0.0, 0.0), turned, (0.0, 0.0))
    machine.hinge(turned, (2.0, 0.0), rod, (-1.75, 0.0))
    machine.hinge(rod, (1.75, 0.0), slider, (0.0, 0.0))
    sliding = [
        machine.system.AddMarker(MarkerBodyRigid(bodyNumber=body))
        for body in (machine.ground, slider)
    ]
    machine.system.AddObject(
        ObjectJointPrismatic2D(
            markerNumbers=sliding, axisMarker0=[1.0, 0.0, 0.0], normalMarker1=[0.0, 1.0, 0.0]
        )
    )
    machine.torque(turned, slider_crank.PARAMETERS[1])
    halved(problem, machine, 8000)


def squeezer(problem: Problem) -> None:
    """Andrews' mechanism."""
    a = andrews
    beta, _, rod, gamma, phi, delta, end, epsilon = a.START
    machine = Machine((0.0, 0.0))
    c, s = math.cos, math.sin

    def turned(x: float, y: float, angle: float) -> Vector:
        return x * c(angle) - y * s(angle), x * s(angle) + y * c(angle)

    def put(mass: float, inertia: float, at: Vector, here: Vector, angle: float) -> Any:
        """A body whose point `here`, in its axes, lies at a place."""
        x, y = turned(*here, angle)
        return machine.body(mass, inertia, (at[0] - x, at[1] - y, angle))

    A, B = (a.XA, a.YA), (a.XB, a.YB)
    e = turned(a.RR, 0.0, beta)
    g = turned(a.ZT, 0.0, delta)
    h = turned(0.0, -a.U, epsilon)
    g, h = (A[0] + g[0], A[1] + g[1]), (A[0] + h[0], A[1] + h[1])
    k1 = put(0.04325, 2.194e-6, (0.0, 0.0), (-a.RA, 0.0), beta)
    k2 = put(a.M2, a.I2, e, (a.DA, 0.0), rod)
    k3 = put(0.02373, 5.255e-6, B, (-a.SB, a.SA), gamma)
    k4 = put(a.M4, a.I4, g, (0.0, a.E - a.EA), phi)
    k5 = put(0.07050, 1.169e-5, A, (-a.TA, -a.TB), delta)
    k6 = put(a.M6, a.I6, h, (a.FA - a.ZF, 0.0), end)
    k7 = put(0.05498, 1.912e-5, A, (a.UB, a.UA), epsilon)
    ground, far = machine.ground, (a.DA - a.D, 0.0)
    machine.hinge(ground, (0.0, 0.0), k1, (-a.RA, 0.0))
    machine.hinge(k1, (a.RR - a.RA, 0.0), k2, (a.DA, 0.0))
    machine.hinge(ground, B, k3, (-a.SB, a.SA))
    machine.hinge(ground, A, k5, (-a.TA, -a.TB))
    machine.hinge(k5, (a.ZT - a.TA, -a.TB), k4, (0.0, a.E - a.EA))
    machine.hinge(ground, A, k7, (a.UB, a.UA))
    machine.hinge(k7, (a.UB, a.UA - a.U), k6, (a.FA - a.ZF, 0.0))
    machine.hinge(k2, far, k3, (-a.SB, a.SA - a.SS))
    machine.hinge(k2, far, k4, (0.0, -a.EA))
    machine.hinge(k2, far, k6, (a.FA, 0.0))
    ends = [machine.point(ground, (a.XC, a.YC)), machine.point(k3, (a.SD - a.SB, a.SA - a.SC))]
    machine.system.AddObject(
        ObjectConnectorSpringDamper(
            markerNumbers=ends, stiffness=a.STIFFNESS, damping=0.0, referenceLength=a.FREE_LENGTH
        )
    )
    machine.torque(k1, a.TORQUE)
    halved(problem, machine, 2000)


def loops(problem: Problem) -> None:
    """The parallel four-bars in a row, upright with their upper joints at 1 m/s."""
    count = int(problem.name.rpartition("_")[2])
    machine = Machine((0.0, -GRAVITY))
    upright = math.pi / 2
    cranks = [
        machine.body(1.0, 1 / 12, (k, 0.5, upright), (0.5, 0.0, -1.0)) for k in range(count + 1)
    ]
    for k, body in enumerate(cranks):
        machine.hinge(machine.ground, (float(k), 0.0), body, (-0.5, 0.0))
    for k in range(count):
        coupler = machine.body(1.0, 1 / 12, (k + 0.5, 1.0, 0.0), (1.0, 0.0, 0.0))
        machine.hinge(cranks[k], (0.5, 0.0), coupler, (-0.5, 0.0))
        machine.hinge(cranks[k + 1], (0.5, 0.0), coupler, (0.5, 0.0))
    # Tighter, Newton's method gives up where the bars are level.
    halved(problem, machine, 2000, sparse=count > 5, newton=1e-8)


def chain(problem: Problem) -> None:
    """The tree in the angles of its joints, by explicit methods, the last one adaptive."""
    links = len(problem.reference)
    container = exu.SystemContainer()
    system = container.AddSystem()
    none = [0.0] * links
    node = system.AddNode(
        NodeGenericODE2(
            referenceCoordinates=none,
            initialCoordinates=none,
            initialCoordinates_t=none,
            numberOfODE2Coordinates=links,
        )
    )
    system.AddObject(
        ObjectKinematicTree(
            nodeNumber=node,
            jointTypes=[exu.JointType.RevoluteZ] * links,
            linkParents=list(range(-1, links - 1)),
            jointTransformations=exu.Matrix3DList([np.eye(3)] * links),
            jointOffsets=exu.Vector3DList([[float(k > 0), 0.0, 0.0] for k in range(links)]),
            linkInertiasCOM=exu.Matrix3DList([np.eye(3) / 12] * links),
            linkCOMs=exu.Vector3DList([[0.5, 0.0, 0.0]] * links),
            linkMasses=[1.0] * links,
            gravity=[0.0, -GRAVITY, 0.0],
        )
    )
    system.Assemble()
    kinds = exu.DynamicSolverType
    shown = exu.OutputVariableType.Coordinates

    def solved(made: Any, kind: Any) -> Any:
        if not system.SolveDynamic(made, solverType=kind, updateInitialValues=False):
            raise RuntimeError("the solver gave up")
        return np.cumsum(system.GetNodeOutput(node, shown))

    for method, kind in (("RK44", kinds.RK44), ("RK67", kinds.RK67)):
        sweep(
            problem,
            "exudyn",
            f"tree, {method}",
            [problem.duration / (100 * 2**k) for k in range(9)],
            lambda h, kind=kind: solved(
                settings(problem.duration, round(problem.duration / h), False), kind
            ),
        )

    def adaptive(tolerance: float) -> Any:
        made = settings(problem.duration, 20, False)
        made.timeIntegration.absoluteTolerance = tolerance
        made.timeIntegration.relativeTolerance = tolerance
        made.timeIntegration.automaticStepSize = True
        made.timeIntegration.minimumStepSize = 1e-12
        return solved(made, kinds.DOPRI5)

    sweep(problem, "exudyn", "tree, DOPRI5", TOLERANCES, adaptive)


SOLVERS = {
    "slider_crank": crank,
    "andrews": squeezer,
    "chain_10": chain,
    "chain_100": chain,
    **{f"n_four_bar_{n}": loops for n in (2, 5, 10, 40)},
}

if __name__ == "__main__":
    main(["exudyn"], SOLVERS)

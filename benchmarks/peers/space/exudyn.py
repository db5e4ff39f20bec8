"""Exudyn in space: chains as trees in the angles of their hinges, other machines as bodies.

Its explicit methods take no joints, so that loops go with the implicit ones, generalized-α of
index 3 and the trapezoidal rule of index 2. Bricard's linkage is a tree whose last hinge is a
constraint, without the one row that follows from the others and would make its matrix singular. The
slider-crank is three bodies with Euler parameters. Each of the two takes longer the other way.
"""

from collections.abc import Callable
from typing import Any

import exudyn as exu
import numpy as np
from exudyn.itemInterface import (
    MarkerBodyRigid,
    MarkerKinematicTreeRigid,
    NodeGenericODE2,
    ObjectGround,
    ObjectJointGeneric,
    ObjectKinematicTree,
    SensorKinematicTree,
)
from exudyn.rigidBodyUtilities import RigidBodyInertia

from benchmarks.peers.exudyn import IMPLICIT, settings
from benchmarks.peers.protocol import TOLERANCES, main, sweep
from benchmarks.problems import Problem
from benchmarks.space_machines import ARM, BRICARD, Chain, Platform, SliderCrank, X, Y, Z

KINDS = exu.DynamicSolverType
TURNS = {X: exu.JointType.RevoluteX, Y: exu.JointType.RevoluteY, Z: exu.JointType.RevoluteZ}
CLOSING_ROWS = [1, 1, 1, 0, 1, 0]
"""Of Bricard's last hinge, about x: its turn is free, and one row is redundant."""
NEWTON = 1e-10
Answer = Callable[[], Any]
CONTAINERS: list[Any] = []
"""A system lives as long as its container."""


def empty_system() -> Any:
    """A system without bodies."""
    CONTAINERS.append(exu.SystemContainer())
    return CONTAINERS[-1].AddSystem()


def solved(system: Any, options: Any, kind: Any, answer: Answer) -> Any:
    """One run."""
    if not system.SolveDynamic(options, solverType=kind, updateInitialValues=False):
        raise RuntimeError("the solver gave up")
    return answer()


def implicit(problem: Problem, form: str, system: Any, answer: Answer, first: int) -> None:
    """Both implicit methods over steps."""
    system.Assemble()
    for method, kind in IMPLICIT.items():

        def run(h: float, kind: Any = kind) -> Any:
            options = settings(problem.duration, round(problem.duration / h), False, NEWTON)
            return solved(system, options, kind, answer)

        steps = [problem.duration / (first * 3**k) for k in range(6)]
        sweep(problem, "exudyn", f"{form}, {method}", steps, run)


def explicit(problem: Problem, form: str, system: Any, answer: Answer) -> None:
    """Its Runge-Kutta method of highest order over steps, and DOPRI5 over tolerances."""
    system.Assemble()

    def equal(h: float) -> Any:
        options = settings(problem.duration, round(problem.duration / h), False)
        return solved(system, options, KINDS.RK67, answer)

    def adaptive(tolerance: float) -> Any:
        options = settings(problem.duration, 20, False)
        options.timeIntegration.absoluteTolerance = tolerance
        options.timeIntegration.relativeTolerance = tolerance
        options.timeIntegration.automaticStepSize = True
        options.timeIntegration.minimumStepSize = 1e-12
        return solved(system, options, KINDS.DOPRI5, answer)

    steps = [problem.duration / (200 * 2**k) for k in range(7)]
    sweep(problem, "exudyn", f"{form}, RK67", steps, equal)
    sweep(problem, "exudyn", f"{form}, DOPRI5", TOLERANCES[::2], adaptive)


def tree_of(system: Any, chain: Chain, body: str) -> Answer:
    """The links of a chain and the hinge that closes it; the answer is a body's centre of mass."""
    links = chain.links
    none = [0.0] * len(links)
    hinges = [np.array(link.hinge, float) for link in links]
    centres = [np.array(link.centre) - hinge for link, hinge in zip(links, hinges, strict=True)]
    offsets = [b - a for a, b in zip([np.zeros(3), *hinges], hinges, strict=False)]
    node = system.AddNode(
        NodeGenericODE2(
            referenceCoordinates=none,
            initialCoordinates=none,
            initialCoordinates_t=none,
            numberOfODE2Coordinates=len(links),
        )
    )
    tree = system.AddObject(
        ObjectKinematicTree(
            nodeNumber=node,
            gravity=list(chain.gravity),
            linkParents=list(range(-1, len(links) - 1)),
            jointTypes=[TURNS[link.axis] for link in links],
            jointTransformations=exu.Matrix3DList([np.eye(3)] * len(links)),
            jointOffsets=exu.Vector3DList([list(offset) for offset in offsets]),
            linkMasses=[link.mass for link in links],
            linkCOMs=exu.Vector3DList([list(centre) for centre in centres]),
            linkInertiasCOM=exu.Matrix3DList([np.diag(link.moments) for link in links]),
        )
    )
    if chain.closing:
        at = np.array(chain.closing[0])
        base = system.AddObject(ObjectGround())
        fixed = system.AddMarker(MarkerBodyRigid(bodyNumber=base, localPosition=list(at)))
        moving = system.AddMarker(
            MarkerKinematicTreeRigid(
                objectNumber=tree, linkNumber=len(links) - 1, localPosition=list(at - hinges[-1])
            )
        )
        system.AddObject(
            ObjectJointGeneric(markerNumbers=[fixed, moving], constrainedAxes=CLOSING_ROWS)
        )
    number = [link.name for link in links].index(body)
    sensor = system.AddSensor(
        SensorKinematicTree(
            objectNumber=tree,
            linkNumber=number,
            localPosition=list(centres[number]),
            outputVariableType=exu.OutputVariableType.Position,
            writeToFile=False,
        )
    )
    return lambda: system.GetSensorValues(sensor)


def rigid(system: Any, mass: float, at: Any, inertia: Any, gravity: Any, **more: Any) -> Any:
    """A body of its own, and where its centre of mass is."""
    about = RigidBodyInertia(mass=mass, inertiaTensor=np.array(inertia, float))
    body = system.CreateRigidBody(
        referencePosition=list(map(float, at)), inertia=about, gravity=list(gravity), **more
    )
    kind = exu.OutputVariableType.Position
    return body, lambda: system.GetObjectOutputBody(body, kind, [0.0, 0.0, 0.0])


def arm(problem: Problem) -> None:
    """The tree alone."""
    system = empty_system()
    explicit(problem, "tree", system, tree_of(system, ARM, "tool"))


def bricard(problem: Problem) -> None:
    """The tree with its last hinge."""
    system = empty_system()
    implicit(problem, "tree", system, tree_of(system, BRICARD, "b3"), 500)


def crank(problem: Problem) -> None:
    """Three bodies with four joints."""
    s, system = SliderCrank, empty_system()
    A, B, C, middle = map(np.array, (s.A, s.B, s.C, s.middle))
    along, about, across, turning = s.rates
    turn = about * np.array(X) + across * np.array(s.across)
    sliding = np.array([along, 0.0, 0.0])
    ground = system.CreateGround()
    wheel = np.diag(s.crank[1])
    pivot, _ = rigid(
        system, s.crank[0], A, wheel, s.gravity, initialAngularVelocity=[turning, 0.0, 0.0]
    )
    rod, answer = rigid(
        system,
        s.rod[0],
        middle,
        s.rod_inertia(),
        s.gravity,
        initialVelocity=list(sliding + np.cross(turn, middle - C)),
        initialAngularVelocity=list(turn),
    )
    block = np.diag(s.slider[1])
    slider, _ = rigid(system, s.slider[0], C, block, s.gravity, initialVelocity=list(sliding))
    system.CreateRevoluteJoint(itemNumbers=[ground, pivot], position=A, axis=list(X))
    system.CreateSphericalJoint(itemNumbers=[pivot, rod], position=B)
    system.CreateGenericJoint(
        itemNumbers=[slider, rod],
        position=C,
        rotationMatrixAxes=np.column_stack([X, s.across, np.cross(X, s.across)]),
        constrainedAxes=[1, 1, 1, 0, 0, 1],
    )
    system.CreatePrismaticJoint(itemNumbers=[ground, slider], position=C, axis=list(X))
    implicit(problem, "bodies", system, answer, 1000)


def platform(problem: Problem) -> None:
    """A free body with Tait-Bryan angles on spring-dampers."""
    p, system = Platform, empty_system()
    w, x, y, z = p.attitude
    turned = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    plate, answer = rigid(
        system,
        p.mass,
        p.place,
        np.diag(p.moments),
        p.gravity,
        referenceRotationMatrix=turned,
        nodeType=exu.NodeType.RotationRxyz,
    )
    ground = system.CreateGround()
    for base, on in p.legs():
        system.CreateSpringDamper(
            itemNumbers=[ground, plate],
            localPosition0=list(base),
            localPosition1=list(on),
            referenceLength=p.rest,
            stiffness=p.stiffness,
        )
    explicit(problem, "body", system, answer)


SOLVERS = {
    "bricard": bricard,
    "spatial_slider_crank": crank,
    "stewart_platform": platform,
    "six_revolute_arm": arm,
}

if __name__ == "__main__":
    main(["exudyn"], SOLVERS)

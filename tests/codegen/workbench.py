"""Machines for the tests of the compiler: interpreted, random, or as plain Python functions."""

import cmath
import math
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np

from codegen import Model
from codegen.derive.equations import Equations, derive
from codegen.elements.registry import kinds_of_elements
from codegen.emit.module import Origin, module_text
from codegen.generated_files.provenance import fingerprint
from codegen.lower.interpreter import evaluate
from codegen.lower.lowered_scene import Lowered, lower
from codegen.reading.scene_selection import valid_scenes

STEP = 1e-40
RETURNED = {"potential", "kinetic_energy"}


def A(phi: float) -> np.ndarray:
    """Rotation matrix."""
    return np.array([[np.cos(phi), -np.sin(phi)], [np.sin(phi), np.cos(phi)]])


def B(phi: float) -> np.ndarray:
    """dA/dφ."""
    return np.array([[-np.sin(phi), -np.cos(phi)], [np.cos(phi), -np.sin(phi)]])


class State(SimpleNamespace):
    """t, q, v of a machine, with the parts of a body at hand."""

    def body(self, k: int | None) -> tuple[np.ndarray, float, np.ndarray, float]:
        """r, φ, ṙ, ω of body `k`; zeros for the ground."""
        if k is None:
            return np.zeros(2), 0.0, np.zeros(2), 0.0
        q, v = self.q[3 * k : 3 * k + 3], self.v[3 * k : 3 * k + 3]
        return q[:2], q[2], v[:2], v[2]


def library_kinds(role: str) -> set[str]:
    """The library's kinds of a role, ``"joint"``, ``"driver"`` or ``"force"``."""
    registered = kinds_of_elements().values()
    return {k.name for k in registered if k.role == role and not k.is_user_defined}


class Interpreted:
    """A scene whose kernels are evaluated by the interpreter, with dense answers."""

    def __init__(self, model: Model, scene: str | None = None) -> None:
        chosen = valid_scenes(model, scene)[0]
        self.equations: Equations = derive(model, chosen)
        self.lowered: Lowered = lower(self.equations)
        self.program = self.lowered.program
        self.n = len(self.equations.coordinates)
        self.m = sum(len(c.terms.phi) for c in self.equations.constraints)
        self.s = len(self.equations.switches)
        self.p = [p.value for p in self.equations.parameters]

    def state(self, seed: int, t: float = 0.7) -> State:
        """A state anywhere, whether the constraints hold or not."""
        random = np.random.default_rng(seed)
        return State(t=t, q=random.uniform(-2, 2, self.n), v=random.uniform(-2, 2, self.n))

    def on_its_sides(self, state: State) -> State:
        """The state with the modes of the sides on which its switching functions are."""
        state.modes = [int(g > 0.0) for g in self.vector("switching", state)]
        return state

    def slots(self, kernel: str, state: Any, **more: Any) -> dict[int, float]:
        """What a kernel stores into its one array: slot → value."""
        filled = self._evaluated(kernel, state, math, more)
        return next(iter(filled.values()), {})

    def _evaluated(
        self, kernel: str, state: Any, functions: ModuleType, more: dict[str, Any]
    ) -> dict[str, dict[int, Any]]:
        inputs = {"t": state.t, "q": state.q, "v": state.v, "p": self.p}
        inputs["modes"] = getattr(state, "modes", [1] * self.s)
        inputs = {k: plain(x) for k, x in (inputs | more).items()}
        return evaluate(self.program, kernel, inputs, functions)

    def flat(self, kernel: str, state: Any, functions: ModuleType = math, **more: Any) -> Any:
        """All outputs of a kernel: array → vector."""
        slots = self._evaluated(kernel, state, functions, more)
        return {k: np.array([x[i] for i in range(len(x))]) for k, x in slots.items()}

    def vector(self, kernel: str, state: Any, functions: ModuleType = math, **more: Any) -> Any:
        """The one output of a kernel."""
        arrays = self.flat(kernel, state, functions, **more)
        if not arrays:
            return np.zeros(0)
        (values,) = arrays.values()
        return values[0] if kernel in RETURNED else values

    def jacobian(self, state: Any, functions: ModuleType = math, **more: Any) -> np.ndarray:
        """Φ_q, m × n."""
        values = self.vector("jacobian", state, functions, **more)
        dense = np.zeros((self.m, self.n), dtype=values.dtype)
        dense[
            list(self.lowered.description.jacobian.rows),
            list(self.lowered.description.jacobian.columns),
        ] = values
        return dense

    def mass(self, state: Any) -> np.ndarray:
        """M, n × n."""
        return np.diag(self.vector("mass", state))

    def solution(self, state: Any, **more: Any) -> tuple[np.ndarray, np.ndarray]:
        """Accelerations and multipliers."""
        out = self.flat("accelerations", state, **more)
        return out["a"], out.get("lam", np.zeros(0))

    def corrected(self, state: Any, w: Any = None, **more: Any) -> State:
        """The state with its velocities (and, to first order, positions) on the constraints."""
        out = self.flat("correction", state, w=np.ones(self.n) if w is None else w, **more)
        return State(t=state.t, q=state.q + out["dq"], v=state.v + out["dv"])

    def text(self) -> str:
        """The generated module."""
        origin = Origin("linkwright", (("m.py", "0" * 64),), fingerprint(self.equations), "build")
        return module_text(self.lowered, origin)


def plain(value: Any) -> Any:
    """Python's own numbers."""
    return value.tolist() if isinstance(value, np.ndarray) else value


def complex_step(function: Callable[[np.ndarray], np.ndarray], x: np.ndarray) -> np.ndarray:
    """Jacobian of `function`, to the last digit."""
    columns = []
    for k in range(len(x)):
        moved = x.astype(complex)
        moved[k] += 1j * STEP
        columns.append(np.imag(function(moved)) / STEP)
    return np.array(columns).T


def along(function: Callable[[complex], np.ndarray]) -> np.ndarray:
    """Derivative of `function` of one number at 0."""
    return np.imag(function(1j * STEP)) / STEP


def complex_gamma(machine: Interpreted, s: State) -> np.ndarray:
    """γ as -d/dt (Φ_q q̇ + Φ_t) along a motion of constant velocity."""

    def velocity_residual(h: complex) -> np.ndarray:
        moved = State(t=s.t + h, q=s.q + h * s.v, v=s.v)
        rows = machine.jacobian(moved, cmath) @ s.v
        return rows - machine.vector("velocity_rhs", moved, cmath)

    return -along(velocity_residual)


def python_functions(text: str) -> dict[str, Any]:
    """The functions and tables of a generated module, run by Python itself."""
    stub = SimpleNamespace(njit=lambda *_, **__: lambda function: function)
    namespace: dict[str, Any] = {"numba": stub}
    exec(compile(text.replace("\nimport numba\n", "\n"), "generated", "exec"), namespace)
    return namespace


def write_model(folder: Path, text: str, name: str = "machine") -> Path:
    """A model file that begins as most do."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.py"
    head = "from codegen import Model, t\nfrom sympy import *\nfrom codegen import t\n\n"
    path.write_text(head + text)
    return path


def random_machine(seed: int, closed: bool = True) -> tuple[Model, State]:
    """A chain of bodies by joints of all kinds, and a state at which they fit together."""
    random = np.random.default_rng(seed)
    model = Model(f"random_{seed}")
    count = int(random.integers(2, 5))
    q = random.uniform(-2, 2, (count, 3))
    bodies = [
        model.body(f"b{k}", *(float(x) for x in random.uniform(0.5, 3, 2))) for k in range(count)
    ]

    def somewhere() -> np.ndarray:
        return random.uniform(-1, 1, 2)

    for k, body in enumerate(bodies):
        previous = model.ground if k == 0 else bodies[k - 1]
        r_i, phi_i = (np.zeros(2), 0.0) if k == 0 else (q[k - 1, :2], q[k - 1, 2])
        r_j, phi_j = q[k, :2], q[k, 2]
        s_i = somewhere()
        place = r_i + A(phi_i) @ s_i
        kind = random.choice(
            ["revolute", "translational", "link", "absolute"], p=[0.5, 0.2, 0.2, 0.1]
        )
        if kind == "revolute":
            s_j = A(phi_j).T @ (place - r_j)
            model.revolute(f"J{k}", previous.at(*s_i), body.at(*s_j))
        elif kind == "translational":
            axis = somewhere()
            s_j = A(phi_j).T @ (place + random.uniform(-1, 1) * A(phi_i) @ axis - r_j)
            angle = float(phi_j - phi_i)
            model.translational(
                f"J{k}", previous.at(*s_i), body.at(*s_j), axis=tuple(axis), angle=angle
            )
        elif kind == "link":
            s_j = somewhere()
            length = float(np.linalg.norm(r_j + A(phi_j) @ s_j - place))
            model.revolute_revolute(f"J{k}", previous.at(*s_i), body.at(*s_j), length)
        else:
            s_j = somewhere()
            value = float((r_j + A(phi_j) @ s_j)[1])
            model.absolute(f"J{k}", body.at(*s_j), "y", value)
    if closed:
        s_i, s_j = somewhere(), somewhere()
        end = q[-1, :2] + A(q[-1, 2]) @ s_j
        model.revolute_revolute(
            "closing", model.ground.at(*s_i), bodies[-1].at(*s_j), float(np.linalg.norm(end - s_i))
        )
    model.gravity("weight", (0.3, -9.81))
    model.torque("motor", on=bodies[0], value=3.0 - 0.2 * bodies[0].omega)
    model.force("push", on=bodies[-1].at(0.4, -0.2), fx=2.0, fy=bodies[0].vx, frame="body")
    return model, State(t=0.3, q=q.ravel(), v=random.uniform(-2, 2, 3 * count))

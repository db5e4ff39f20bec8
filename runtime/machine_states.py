"""Tables of a machine as a user reads them, its parameter values, modes and assembled states."""

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.object_display import counted, html_of, html_table
from codegen.presentation import in_pyplot
from codegen.readers.calls import checked_class
from codegen.readers.values import shown
from runtime.core.arrays import Vector
from runtime.core.kernel_abi import Kernels
from runtime.mechanism.mechanism import Mechanism, Values
from runtime.mechanism.module_tables import Description
from runtime.mechanism.table_rows import TRACKED, Constraint, Coordinate, Effect, Parameter, Table
from runtime.mechanism.table_rows import State as StateRow
from runtime.progress_bar import shows_compilation
from runtime.validation.arguments import check, parameter_values
from runtime.validation.scene_support import require_plane

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from runtime.assembly.assembly_modes import AssemblyModes
    from runtime.continuation.motion_limits import MotionLimits
    from runtime.results.assembled_state import Assembly, State
    from runtime.results.result import Result


_SHOWN = 8  # layout: parameters that the text names


@checked_class
class MachineStates:
    """A mechanism in one scene, before any analysis; `mechanism` has the data for analyses."""

    mechanism: Mechanism

    def __init__(self, mechanism: Mechanism) -> None:
        if not isinstance(mechanism, Mechanism):
            raise InputError(f"{shown(mechanism)} is no mechanism; runtime.load makes machines.")
        self.mechanism = mechanism

    @property
    def description(self) -> Description:
        """The tables of the generated module."""
        return self.mechanism.description

    @property
    def kernels(self) -> Kernels:
        """The compiled functions of the scene, callable from any numba code."""
        return self.mechanism.kernels

    @property
    def path(self) -> Path:
        """File of the generated module."""
        return self.mechanism.path

    @property
    def model(self) -> str:
        """Name of the model."""
        return self.description.model

    @property
    def scene(self) -> str:
        """Name of the scene."""
        return self.description.scene

    @property
    def coordinates(self) -> Table[Coordinate]:
        """Generalized coordinates with their velocities and units, in the order of q."""
        return self.description.coordinates

    @property
    def states(self) -> Table[StateRow]:
        """First-order states, sampled values and latches, with units and columns in v."""
        return self.description.states

    @property
    def constraints(self) -> Table[Constraint]:
        """Scalar constraints, in the order of Φ and of the multipliers λ."""
        return self.description.constraints

    @property
    def parameters(self) -> Table[Parameter]:
        """Declared parameters with their defaults and units, in the order of p."""
        return self.description.parameters

    @property
    def effects(self) -> Table[Effect]:
        """Gravity, forces, springs, contacts and frictions that act in this scene."""
        description = self.description
        others = {*description.states.names, *description.tracked}
        return Table(row for row in description.effects if row.name not in others)

    def __repr__(self) -> str:
        """Sizes, bodies, effects and the first parameters."""
        description, parameters = self.description, self.parameters
        drivers = int(description.driver_rows.sum())
        lines = [
            f"{description.title}: {counted(len(description.bodies), 'body')}, "
            f"{counted(len(description.positions), 'coordinate')}, "
            f"{counted(len(self.constraints), 'constraint')}"
            + (f" ({drivers} of drivers)" if drivers else ""),
            f"  bodies      {', '.join(description.bodies)}",
            f"  effects     {', '.join(self.effects.names) or 'none'}",
        ]
        if self.states:
            lines.append(f"  states      {', '.join(self.states.names)}")
        if description.tracked:
            lines.append(f"  points      {', '.join(description.tracked)}")
        absent = [row.name for row in description.left_out if row.kind != TRACKED]
        if absent:
            lines.append(f"  left out    {', '.join(absent)}")
        if not description.has_masses:
            lines.append("  no masses: kinematics only")
        shown = ", ".join(f"{row.name} = {row.default:g} {row.unit}" for row in parameters[:_SHOWN])
        more = len(parameters) - _SHOWN
        if parameters:
            lines.append(f"  parameters  {shown}{f', and {more} more' if more > 0 else ''}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        """The same with a table of all parameters, for notebooks."""
        values = ((row.name, row.default, row.unit) for row in self.parameters)
        text = (line for line in repr(self).splitlines() if not line.startswith("  parameters "))
        return html_of("\n".join(text), html_table(("parameter", "default", "unit"), values))

    @cached_property
    def degrees_of_freedom(self) -> int:
        """Coordinates minus independent constraints, drivers included, at the start.

        States of first order and sampled values do not count: `states` has them.

        Raises
        ------
        AssemblyError
            If the scene's start cannot be assembled.
        """
        return self.assemble().degrees_of_freedom

    @property
    def is_determined(self) -> bool:
        """Whether joints and drivers leave nothing to integrate: no freedom and no state.

        Raises
        ------
        AssemblyError
            If the scene's start cannot be assembled.
        """
        return self.degrees_of_freedom == 0 and not self.states

    def parameter_values(self, overrides: Values | None = None) -> Vector:
        """Parameters followed by the constants derived from them, as the kernels take them.

        Parameters
        ----------
        overrides
            New values by name, SI units or texts, ``"45 mm"``; the others keep their defaults.

        Returns
        -------
        (np,) float64

        Raises
        ------
        InputError, ParameterError
            If `overrides` is not a mapping from names to numbers. One sentence for each name that
            is unknown, each value that is not finite or of the wrong sign, and coefficients that
            make no sense.
        """
        return parameter_values(self.mechanism, overrides)

    @shows_compilation
    def initial_modes(
        self, t: float = 0.0, q: Vector | None = None, v: Vector | None = None,
        parameters: Values | None = None,
    ) -> npt.NDArray[np.int64]:  # fmt: skip
        """Modes of the switching functions at a state, as the kernels take them.

        Parameters
        ----------
        t
            Instant in s.
        q, v : (n,)
            A state on the constraints; the assembled start unless both are given.
        parameters
            Values by name, SI units or texts, ``"45 mm"``; the others keep their defaults.

        Returns
        -------
        (s,) int64
            1 if the condition holds, or begins to hold at its boundary; 0 if it does not; 2 if the
            switching function stays at zero: the motion slides on the switching surface, friction
            sticks, or a rigid contact is closed.

        Raises
        ------
        InputError
            If t, q or v are not finite numbers of the right shape.
        AnalysisError
            If no run can start from the state, as with a joint that jams.
        """
        from runtime.integrate.run import initial_modes

        state: dict[str, Any] = {} if q is None and v is None else {"q": q, "v": v}
        given = check(self.mechanism, {"t": t, "parameters": parameters, **state})
        t, parameters = given["t"], given["parameters"]
        p = self.parameter_values(parameters)
        if not self.description.switches:
            return np.zeros(0, dtype=np.int64)
        if q is None or v is None:
            start = self.assemble(parameters=parameters, t=t)
            q, v = start.q, start.v
        return initial_modes(self.mechanism.system, t, q, v, p)

    @in_pyplot()
    @shows_compilation
    def draw(
        self, at: "float | State | Assembly | Result" = 0.0, *, parameters: Values | None = None,
        guess: Values | None = None, dimensions: bool = False, forces: bool = False,
        frames: bool = False, names: bool = True, view: str = "usual",
    ) -> "Figure":  # fmt: skip
        """Draw the machine at its start, or at a state.

        Parameters
        ----------
        at
            An instant in s, at which the start is assembled, with drivers at their values then; or
            a state from `assemble` or `Result.state(t)`; or a result, for the state at its end.
        parameters, guess
            As for `assemble`: values by name, in SI units or as texts, ``"45 mm"``.
        dimensions, forces, frames, names, view
            As for `Model.draw`; forces are the applied forces. `Result.draw` draws reactions, too.

        Raises
        ------
        AssemblyError, InputError
            As `assemble`; if an argument is of the wrong kind, or Matplotlib is not installed.
        """
        options = check(self.mechanism, locals())
        from runtime.show.pictures import draw_state

        values, state = options.pop("parameters"), options.pop("at")
        guess = options.pop("guess")
        if isinstance(state, float):
            state = self.assemble(guess, values, state)
        return draw_state(self.mechanism, state, self.parameter_values(values), **options)

    @shows_compilation
    def assemble(
        self, guess: Values | None = None, parameters: Values | None = None, t: float = 0.0, *,
        start: Values | None = None,
    ) -> "Assembly":  # fmt: skip
        """Positions and velocities that satisfy the joints and the drivers at time t.

        Start values with the role "fixed" and those of `start` are kept. The others are guesses:
        positions move as little as closing the joints allows, velocities as little as Φ_q v = ν
        allows.

        Parameters
        ----------
        guess
            Values by name of coordinate or velocity, SI units or texts, ``"30 deg"``, at which the
            search begins, in place of the scene's guesses. Names that the scene or `start` fixes
            are refused.
        parameters, t
            Values by name, SI units or texts, ``"45 mm"``; other parameters keep their defaults.
            Instant in s.
        start
            Values by name, as in `guess`, that assembly keeps, in place of the values that the
            scene fixes.

        Returns
        -------
        Assembly
            The state, its residuals, the coordinates that had to move, the degrees of freedom, and
            redundant or singular constraints.

        Raises
        ------
        AssemblyError
            If the joints do not close: the message names the joints, with the remaining gaps. If
            `guess` names values that the scene fixes: the message has the scene's values.
        InputError
            If a name is in `guess` and in `start`, or an argument is of another kind.
        RedundancyError
            If constraints contradict each other, or a driver drives what the joints determine.
        """
        given = check(self.mechanism, locals(), start_has_values=True)
        from runtime.assembly.assemble import assemble
        from runtime.mechanism.dense_equations import Equations

        equations = Equations(self.mechanism, self.parameter_values(given["parameters"]))
        return assemble(equations, given["t"], given["guess"], given["start"])

    @shows_compilation
    def assembly_modes(
        self, t: float = 0.0, *, start: Values | None = None, parameters: Values | None = None
    ) -> "AssemblyModes":
        """All positions in which the joints close at time t; whole turns make no other position.

        Each is an assembled state as `start=` and `draw` take it, with a label of signs.

        Parameters
        ----------
        t, start, parameters
            As for `assemble`. Start values with the role "fixed" and those of `start` are held:
            they must hold all freedom that the drivers leave.

        Raises
        ------
        AnalysisError, AssemblyError, InputError, RedundancyError
            If freedom is left, or the machine has gears or 300 coordinates; as `assemble`.
        """
        given = check(self.mechanism, locals(), start_has_values=True)
        advice = "Assemble from guesses near the modes that are meant."
        require_plane(self.mechanism, "assembly_modes are", advice)
        from runtime.assembly.assembly_modes import assembly_modes
        from runtime.mechanism.dense_equations import Equations

        equations = Equations(self.mechanism, self.parameter_values(given["parameters"]))
        return assembly_modes(equations, given["t"], given["start"])

    @shows_compilation
    def limits(
        self, coordinate: str, *, start: "Assembly | State | Result | Values | None" = None,
        parameters: Values | None = None, t: float = 0.0,
    ) -> "MotionLimits":  # fmt: skip
        """How far a coordinate moves, where it turns back, dead centres and change points.

        Its drivers are released, or all if it has none: one degree of freedom must be left.

        Parameters
        ----------
        coordinate
            Name of a coordinate, "crank.phi".
        start, parameters, t
            As for `assemble`: the motion goes through this start, with laws of time frozen at t.
            Or `start` is a state, such as one of `assembly_modes`, and t is its instant.

        Raises
        ------
        AnalysisError, AssemblyError, InputError, RedundancyError
            If other freedom is left, joints repeat each other, motions meet at the start or several
            of them elsewhere, or the motion does not close; as `assemble`.
        """
        given = check(self.mechanism, locals())
        advice = "Drive the coordinate in kinematics, which tells where it stops."
        require_plane(self.mechanism, "limits are", advice)
        from runtime.assembly.assemble import assemble
        from runtime.continuation.motion_limits import motion_limits
        from runtime.mechanism.dense_equations import Equations

        equations = Equations(self.mechanism, self.parameter_values(given["parameters"]))
        t = getattr(given["start"], "t", given["t"])
        begin = assemble(equations, t, None, given["start"])
        return motion_limits(equations, begin, given["coordinate"])

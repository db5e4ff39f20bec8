"""What a user holds: a loaded mechanism, its tables, and the analyses."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError, ParameterError
from runtime.core.kernels import Kernels
from runtime.mechanism.description import (
    Constraint,
    Coordinate,
    Description,
    Effect,
    Parameter,
    Table,
)
from runtime.mechanism.parameters import resolved
from runtime.progress_bar import bar
from runtime.validation.arguments import check
from runtime.validation.contacts import require_sound
from runtime.validation.scene_support import require_energy, require_motion

if TYPE_CHECKING:
    from runtime.assembly.assembled_state import Assembly
    from runtime.core.system import System
    from runtime.integrate.problem import Correction, Formulation
    from runtime.mechanism.companion_modules import Kind, Origin
    from runtime.mechanism.reduced_kernels import Reduced
    from runtime.mechanism.tangent_kernels import Tangents
    from runtime.results.result import Result
    from runtime.statics.equilibrium import Equilibrium

FloatArray = npt.NDArray[np.float64]
Values = Mapping[str, float]


class Machine:
    """A mechanism in one scene, ready to be analysed.

    Parameters
    ----------
    description
        The literals of the generated module.
    kernels
        Its compiled functions, callable from any numba code.
    path
        The generated module's file.
    origin
        What it was made from; needed where derivatives are asked for.
    """

    def __init__(
        self,
        description: Description,
        kernels: Kernels,
        path: Path,
        origin: "Origin | None" = None,
    ) -> None:
        self.description = description
        self.kernels = kernels
        self.path = path
        self._origin = origin
        self._independent = tuple(range(len(description.constraints)))
        self._bearing: dict[tuple[int, ...], Machine] = {}

    @cached_property
    def tangents(self) -> "Tangents":
        """Exact derivatives of the kernels: see `runtime.mechanism.tangent_kernels`.

        Their file is built when it is first asked for.

        Raises
        ------
        AnalysisError
            If the scene has no masses, or the machine was not loaded from a model.
        """
        from runtime.mechanism.companion_modules import load_companion
        from runtime.mechanism.tangent_kernels import gather

        if not self.description.has_masses:
            raise AnalysisError(
                f"{self.description.title} is kinematic: no masses move in it, so there are no "
                "accelerations under forces to differentiate. Load a scene with masses."
            )
        title = self.description.title
        return gather(load_companion(self._origin, "tangents", title, self.path))

    @cached_property
    def reduced(self) -> "Reduced":
        """The equations in reduced coordinates, see `runtime.mechanism.reduced_kernels`."""
        from runtime.mechanism.companion_modules import load_companion
        from runtime.mechanism.reduced_kernels import gather

        told = self.description
        return gather(load_companion(self._origin, "reduced", told.title, self.path), told)

    def offers(self, kind: "Kind") -> bool:
        """Whether a companion of the generated module, "tangents" or "reduced", is built."""
        from runtime.mechanism.companion_modules import has_companion

        return kind in self.__dict__ or has_companion(self._origin, kind)

    def bearing(self, independent: tuple[int, ...]) -> "Machine":
        """The machine with kernels that bear redundant constraints.

        Parameters
        ----------
        independent
            Indices of constraints that suffice.
        """
        from runtime.assembly.redundant_kernels import bearing_kernels

        if independent not in self._bearing:
            kernels = bearing_kernels(self.kernels, self.description, len(independent))
            made = Machine(self.description, kernels, self.path, self._origin)
            made._independent = independent
            self._bearing[independent] = made
        return self._bearing[independent]

    @cached_property
    def kernel_table(self) -> npt.NDArray[np.int64]:
        """Addresses of the kernels, for compiled loops of the runtime."""
        return self.kernels.table()

    @cached_property
    def system(self) -> "System":
        """The kernels and sizes that the integrator asks for."""
        from runtime.mechanism.system import system

        told, kernels = self.description, self.kernels
        jacobian = told.jacobian_rows.astype(np.int64), told.jacobian_columns.astype(np.int64)
        return replace(
            system(told, kernels, jacobian, len(told.coordinates), len(told.constraints)),
            reactions=kernels.reactions,
            switched_reactions=kernels.switched_reactions,
            reaction_rows=len(told.reactions),
            limits=told.friction_limits,
            sought=tuple((k, len(told.parameters) + i) for i, k in enumerate(told.sought)),
            independent=self._independent,
        )

    @property
    def independent(self) -> tuple[int, ...]:
        """Indices of constraints of which none follows from others; all but after `bearing`."""
        return self._independent

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
        """Generalized coordinates, in the order of q."""
        return self.description.coordinates

    @property
    def constraints(self) -> Table[Constraint]:
        """Scalar constraints, in the order of the multipliers."""
        return self.description.constraints

    @property
    def parameters(self) -> Table[Parameter]:
        """Declared parameters, in the order of p."""
        return self.description.parameters

    @property
    def effects(self) -> Table[Effect]:
        """What acts on the bodies in this scene."""
        return self.description.effects

    @cached_property
    def degrees_of_freedom(self) -> int:
        """Coordinates less independent constraints, drivers included, where it assembles.

        Raises what `assemble` raises where the machine cannot be assembled.
        """
        return self.assemble().degrees_of_freedom

    def parameter_values(self, overrides: Values | None = None) -> FloatArray:
        """Parameters followed by the constants derived from them.

        Parameters
        ----------
        overrides
            New values by name, in the declared units; the others keep their defaults.
        """
        check(self, parameters=overrides)
        values, problems = resolved(self.description, overrides or {})
        if problems:
            raise ParameterError(problems)
        self.kernels.constants(values)
        require_sound(self, values)
        return values

    def initial_modes(
        self,
        t: float = 0.0,
        q: FloatArray | None = None,
        v: FloatArray | None = None,
        parameters: Values | None = None,
    ) -> npt.NDArray[np.int64]:
        """Which conditions hold at a state, shape (s,): 1 where one does, else 0.

        Without a state it is the assembled start. A condition that is exactly at its boundary
        holds if the motion is about to make it hold; it is 2 where the motion stays on the
        boundary, because both sides push onto it, friction sticks, or a rigid contact is closed.
        """
        from runtime.integrate.run import initial_modes

        check(self, t=t, **({} if q is None and v is None else {"q": q, "v": v}))
        if not self.description.switches:
            return np.zeros(0, dtype=np.int64)
        if q is None or v is None:
            start = self.assemble(parameters=parameters, t=t)
            q, v = start.q, start.v
        return initial_modes(self.system, t, q, v, self.parameter_values(parameters))

    def assemble(
        self,
        guess: Values | None = None,
        parameters: Values | None = None,
        t: float = 0.0,
    ) -> "Assembly":
        """Put the machine together at time t: see `runtime.assembly.assemble`."""
        from runtime.assembly.assemble import assemble

        check(self, guess=guess, parameters=parameters, t=t)
        return assemble(self, guess, parameters, t)

    def simulate(
        self,
        t_end: float,
        t_eval: npt.ArrayLike | None = None,
        *,
        accuracy: float | None = None,
        quantities: Sequence[str] | None = None,
        t_start: float = 0.0,
        method: str | None = None,
        rtol: float | None = None,
        atol: float | None = None,
        parameters: Values | None = None,
        guess: Values | None = None,
        start: "Assembly | None" = None,
        correction: "Correction" = "step",
        formulation: "Formulation | None" = None,
        time_scale: float | None = None,
        first_step: float | None = None,
        max_step: float | None = None,
        max_steps: int = 100_000_000,
        progress: bool = True,
    ) -> "Result":
        """Motion under the forces that act: see `runtime.dynamics.simulation`.

        With `accuracy`, the relative error of the `quantities` that the result may have, in place
        of tolerances: see `runtime.studies.accuracy_target`.
        """
        from runtime.studies.accuracy_target import accuracy_or_tolerances

        require_motion(self, "simulate")
        given: dict[str, Any] = {
            "t_start": t_start,
            "parameters": parameters,
            "guess": guess,
            "start": start,
            "first_step": first_step,
            "max_step": max_step,
            "max_steps": max_steps,
        }
        check(self, t_end=t_end, rtol=rtol, atol=atol, accuracy=accuracy, **given)
        analyse = accuracy_or_tolerances(
            self, accuracy, quantities, rtol, atol, method, formulation
        )
        with bar(f"simulate {self.description.title}", progress) as report:
            return analyse(
                t_end,
                t_eval,
                correction=correction,
                time_scale=time_scale,
                progress=report,
                **given,
            )

    def kinematics(
        self,
        t_eval: npt.ArrayLike,
        *,
        parameters: Values | None = None,
        guess: Values | None = None,
        t_start: float = 0.0,
        progress: bool = True,
    ) -> "Result":
        """Motion of a fully driven machine: see `runtime.dynamics.kinematics`."""
        from runtime.dynamics.kinematics import kinematics

        require_motion(self, "kinematics")
        check(self, parameters=parameters, guess=guess, t_start=t_start)
        with bar(f"kinematics of {self.description.title}", progress) as report:
            return kinematics(
                self, t_eval, parameters=parameters, guess=guess, t_start=t_start, progress=report
            )

    def inverse_dynamics(
        self,
        t_eval: npt.ArrayLike,
        *,
        parameters: Values | None = None,
        guess: Values | None = None,
        t_start: float = 0.0,
        progress: bool = True,
    ) -> "Result":
        """Forces and torques of a prescribed motion: see `runtime.dynamics.inverse_dynamics`."""
        from runtime.dynamics.inverse_dynamics import inverse_dynamics

        require_motion(self, "inverse_dynamics")
        check(self, parameters=parameters, guess=guess, t_start=t_start)
        with bar(f"inverse dynamics of {self.description.title}", progress) as report:
            return inverse_dynamics(
                self, t_eval, parameters=parameters, guess=guess, t_start=t_start, progress=report
            )

    def equilibrium(
        self,
        method: str = "energy",
        *,
        guess: Values | None = None,
        parameters: Values | None = None,
        t: float = 0.0,
        progress: bool = True,
    ) -> "Equilibrium":
        """Where the machine rests: see `runtime.statics.equilibrium`."""
        from runtime.statics.equilibrium import equilibrium

        if method == "settling":
            require_motion(self, 'equilibrium(method="settling")')
        require_energy(self)
        check(self, parameters=parameters, guess=guess, t=t)
        with bar(f"equilibrium of {self.description.title}", progress) as report:
            return equilibrium(
                self, method, guess=guess, parameters=parameters, t=t, progress=report
            )

    def __repr__(self) -> str:
        """Short summary for a person."""
        told = self.description
        rows = [
            f"{told.title}: {len(told.bodies)} bodies, {len(told.coordinates)} coordinates, "
            f"{len(told.constraints)} constraints"
            + (f" ({int(told.driver_rows.sum())} of drivers)" if told.drivers else ""),
            f"  bodies      {', '.join(told.bodies)}",
            f"  effects     {', '.join(told.effects.names) or 'none'}",
        ]
        if told.left_out:
            rows.append(f"  left out    {', '.join(told.left_out.names)}")
        if not told.has_masses:
            rows.append("  no masses: kinematics only")
        shown = ", ".join(f"{row.name} = {row.default:g} {row.unit}" for row in told.parameters[:8])
        more = len(told.parameters) - 8
        rows.append(f"  parameters  {shown}{f', and {more} more' if more > 0 else ''}")
        return "\n".join(rows)

    def _repr_html_(self) -> str:
        """The summary as a table, for notebooks."""
        from html import escape

        rows = "".join(
            f"<tr><td>{escape(row.name)}</td><td style='text-align:right'>{row.default:g}</td>"
            f"<td>{escape(row.unit)}</td></tr>"
            for row in self.parameters
        )
        head = "<br>".join(escape(line) for line in repr(self).splitlines()[:-1])
        return (
            f"<div><p>{head}</p><table><thead><tr><th>parameter</th><th>default</th><th>unit</th>"
            f"</tr></thead><tbody>{rows}</tbody></table></div>"
        )

"""The tables of a mechanism as a user reads them."""

from pathlib import Path

from codegen.errors import InputError
from codegen.object_display import counted, html_of, html_table
from codegen.readers.calls import checked_class
from codegen.readers.values import shown
from runtime.core.kernel_abi import Kernels
from runtime.mechanism import table_rows as rows
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import Description

_SHOWN = 8  # layout: parameters that the text names


@checked_class
class MechanismTables:
    """Tables of a mechanism in one scene; `mechanism` is the data that the analyses take."""

    mechanism: Mechanism

    def __init__(self, mechanism: Mechanism) -> None:
        if not isinstance(mechanism, Mechanism):
            raise InputError(f"{shown(mechanism)} is no mechanism; runtime.load makes machines.")
        vars(self)["mechanism"] = mechanism

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
    def coordinates(self) -> rows.Table[rows.Coordinate]:
        """Generalized coordinates with their velocities and units, in the order of q."""
        return self.description.coordinates

    @property
    def states(self) -> rows.Table[rows.State]:
        """First-order states, sampled values and latches, with units and columns in v."""
        return self.description.states

    @property
    def constraints(self) -> rows.Table[rows.Constraint]:
        """Scalar constraints, in the order of Φ and of the multipliers λ."""
        return self.description.constraints

    @property
    def parameters(self) -> rows.Table[rows.Parameter]:
        """Declared parameters with their defaults and units, in the order of p."""
        return self.description.parameters

    @property
    def effects(self) -> rows.Table[rows.Effect]:
        """Gravity, forces, springs, contacts and frictions that act in this scene."""
        description = self.description
        others = {*description.states.names, *description.tracked}
        return rows.Table(row for row in description.effects if row.name not in others)

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
        absent = [row.name for row in description.left_out if row.kind != rows.TRACKED]
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

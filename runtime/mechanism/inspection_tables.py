"""The tables of a mechanism as a user reads them."""

from pathlib import Path

from codegen.errors import InputError
from codegen.object_display import counted, html_of, html_table
from codegen.plain_values import shown
from codegen.public_callables import checked_class
from runtime.core.kernel_abi import Kernels
from runtime.mechanism import table_rows as rows
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
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
        return self.description.effects

    def __repr__(self) -> str:
        """Sizes, bodies, effects and the first parameters."""
        description, parameters = self.description, self.parameters
        drivers = int(description.driver_rows.sum())
        acting = [name for name in self.effects.names if name not in self.states.names]
        rows = [
            f"{description.title}: {counted(len(description.bodies), 'body')}, "
            f"{counted(len(description.positions), 'coordinate')}, "
            f"{counted(len(self.constraints), 'constraint')}"
            + (f" ({drivers} of drivers)" if drivers else ""),
            f"  bodies      {', '.join(description.bodies)}",
            f"  effects     {', '.join(acting) or 'none'}",
        ]
        if self.states:
            rows.append(f"  states      {', '.join(self.states.names)}")
        if description.left_out:
            rows.append(f"  left out    {', '.join(description.left_out.names)}")
        if not description.has_masses:
            rows.append("  no masses: kinematics only")
        shown = ", ".join(f"{row.name} = {row.default:g} {row.unit}" for row in parameters[:_SHOWN])
        more = len(parameters) - _SHOWN
        rows.append(f"  parameters  {shown}{f', and {more} more' if more > 0 else ''}")
        return "\n".join(rows)

    def _repr_html_(self) -> str:
        """The same with a table of all parameters, for notebooks."""
        rows = ((row.name, row.default, row.unit) for row in self.parameters)
        head = "\n".join(repr(self).splitlines()[:-1])
        return html_of(head, html_table(("parameter", "default", "unit"), rows))

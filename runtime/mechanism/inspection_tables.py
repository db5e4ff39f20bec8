"""The tables of a mechanism as a user reads them."""

from html import escape

from runtime.mechanism.mechanism_tables_and_kernels import Mechanism

_SHOWN = 8  # layout: parameters that the text names


class MechanismTables:
    """Tables of a mechanism in one scene.

    Attributes
    ----------
    mechanism, description, kernels, path
        The data that the analyses take; of these the tables of the generated module, its compiled
        functions, callable from any numba code, and its file.
    model, scene
        Names of the model and of the scene.
    coordinates, constraints
        Generalized coordinates with their velocities and units, in the order of q; scalar
        constraints, in the order of Φ and of the multipliers λ.
    parameters, effects
        Declared parameters with their defaults and units, in the order of p; gravity, forces,
        springs, contacts and frictions that act in this scene.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.kernels, self.path = mechanism, mechanism.kernels, mechanism.path
        self.description = description = mechanism.description
        self.model, self.scene = description.model, description.scene
        self.coordinates, self.constraints = description.coordinates, description.constraints
        self.parameters, self.effects = description.parameters, description.effects

    def __repr__(self) -> str:
        """Sizes, bodies, effects and the first parameters."""
        description, parameters = self.description, self.parameters
        drivers = int(description.driver_rows.sum())
        rows = [
            f"{description.title}: {len(description.bodies)} bodies, {len(self.coordinates)} "
            f"coordinates, {len(self.constraints)} constraints"
            + (f" ({drivers} of drivers)" if drivers else ""),
            f"  bodies      {', '.join(description.bodies)}",
            f"  effects     {', '.join(self.effects.names) or 'none'}",
        ]
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

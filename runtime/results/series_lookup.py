"""Series of a result by name: reactions, modes, energies; and any series."""

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.public_callables import checked_class
from runtime.mechanism.table_rows import unknown
from runtime.results.effect_series import QUANTITIES, EffectSeries
from runtime.results.motion_lookup import FloatArray, by_names

ENERGIES = ("kinetic", "potential", "total")


@checked_class
class TimeSeries(EffectSeries):
    """Samples of a motion, with the tables that name them; see `Result`.

    A name that the scene does not have is refused by an `InputError` with the nearest ones.
    """

    @by_names
    def reaction(self, joint: str, component: str) -> FloatArray:
        """Force or torque that the first body of a joint exerts on the second, in joint axes.

        Of a driver: what it exerts on the body that it drives.

        Parameters
        ----------
        joint
            Name of the joint or driver.
        component
            Such as "fx", "fy" or "torque".

        Returns
        -------
        (k,) float64
            In N or N m.

        Raises
        ------
        InputError
            If there is no such joint or component, or the scene was declared without it.
        """
        rows = self.description.reactions
        if joint in self.description.tracked:
            raise InputError(
                f"{self.description.title}: '{joint}' is a tracked point and transmits nothing; "
                f"ask for point({joint!r})."
            )
        if f"{joint}.{component}" in rows.names:
            return self.samples.reaction[:, rows.index(f"{joint}.{component}")]
        of_joint = [row.component for row in rows if row.element == joint]
        if of_joint:
            raise InputError(
                f"{self.description.title}: joint {joint} has no reaction {component!r}; "
                f"it has {', '.join(of_joint)}."
            )
        joints = {row.element for row in self.description.constraints}
        if joint in joints | {*self.description.effects.names}:
            self._require_output("reaction", joint)
        raise self._unknown("reaction of", joint, dict.fromkeys(row.element for row in rows))

    @by_names
    def mode(self, condition: str) -> npt.NDArray[np.int64]:
        """Mode of a switching condition over time.

        Parameters
        ----------
        condition
            Named as in events, such as "gas: slider_vx > 0", or by its effect where that has one
            condition only.

        Returns
        -------
        (k,) int64
            1 where the condition held, 0 where it did not, 2 where its function stayed at zero: the
            motion slid on the switching surface, friction stuck, or a rigid contact was closed.
        """
        return self.samples.modes[:, self._switch(condition)]

    @by_names
    def share(self, condition: str) -> FloatArray:
        """Filippov's share α of a condition over time, where its mode is 2.

        There the accelerations are (1 - α) times those without the condition plus α times those
        with it. A rigid contact has 1 where its force vanishes; what it exerts is its reaction.

        Parameters
        ----------
        condition
            Named as in `mode`.

        Returns
        -------
        (k,) float64
            From 0 to 1; not a number where the mode is 0 or 1.
        """
        return self.samples.share[:, self._switch(condition)]

    @by_names
    def energy(self, part: str = "total") -> FloatArray:
        """Energy over time.

        Parameters
        ----------
        part
            "kinetic", "potential" or "total".

        Returns
        -------
        (k,) float64
            In J.

        Raises
        ------
        InputError
            If there is no such part, bodies have no mass, or the scene was declared without it.
        """
        if part not in ENERGIES:
            raise InputError(unknown("energy", part, ENERGIES))
        if not self.description.has_masses:
            raise InputError(self.description.need_masses("energy"))
        self._require_output("energy")
        energies = self.samples.energy
        return energies.sum(axis=1) if part == "total" else energies[:, ENERGIES.index(part)]

    @by_names
    def series(self, name: str) -> tuple[FloatArray, str]:
        """A column by any of its names, and its unit.

        Parameters
        ----------
        name
            Of a coordinate, a velocity, a state, `a(coordinate)`, `a(state)`, `joint.component`,
            `point.x`, an energy, the power of a source, or `work(source)`; of an effect
            `strut.force` or `force(strut)`, and so on for lengths, rates and the like.

        Returns
        -------
        values : (k,) float64
        unit : str
        """
        description = self.description
        for row in description.coordinates:
            if name == row.name:
                return self.q(name), row.unit
            if name == row.velocity:
                return self.v(name), row.velocity_unit
            if name == f"a({row.velocity if row.is_state else row.name})":
                return self.a(row.name), row.acceleration_unit
        if name in description.reactions.names:
            reaction = description.reactions[name]
            return self.samples.reaction[:, description.reactions.index(name)], reaction.unit
        if name in ENERGIES and description.has_masses:
            return self.energy(name), "J"
        if name in description.whole_powers:
            return self.power(name), "W"
        word, _, rest = name.partition("(")
        if rest.endswith(")") and word in (*QUANTITIES, "power", "work"):
            return self._of_effect(word, rest[:-1])
        owner, _, component = name.partition(".")
        if owner in description.effects.names and component in QUANTITIES:
            return self._of_effect(component, owner)
        names = [*description.variables, *description.reactions.names]
        raise self._unknown("series", name, names)

    def _of_effect(self, word: str, effect: str) -> tuple[FloatArray, str]:
        """A quantity of an effect that has one component, or its power or work, and the unit."""
        if word in ("power", "work"):
            return getattr(self, word)(effect), "W" if word == "power" else "J"
        column = self._row_of(word, effect)
        return self.samples.reaction[:, column], self.description.reactions[column].unit

    def _switch(self, condition: str) -> int:
        switches = self.description.switches
        full = [row.title for row in switches]
        if condition in full:
            return full.index(condition)
        of_effect = [k for k, row in enumerate(switches) if row.name == condition]
        if len(of_effect) == 1:
            return of_effect[0]
        raise self._unknown("condition", condition, full)

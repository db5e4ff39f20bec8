"""Series of a result by name: coordinates, reactions, modes, powers, works, paths, energies."""

import json
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from codegen import __version__
from codegen.errors import InputError
from runtime.core.outcomes import Outcome
from runtime.mechanism.description import Description, unknown
from runtime.results.event_records import Event
from runtime.results.reached_accuracy import ReachedAccuracy
from runtime.results.samples import Partition, Samples
from runtime.results.singular_positions import SingularPosition

FloatArray = npt.NDArray[np.float64]
ENERGIES = ("kinetic", "potential", "total")


class TimeSeries:
    """Samples of a motion, with the tables that name them; see `Result`.

    A name that the scene does not have is refused by an `InputError` with the nearest ones.
    """

    def __init__(
        self,
        description: Description,
        samples: Samples,
        p: FloatArray,
        *,
        analysis: str,
        outcome: Outcome,
        message: str,
        stats: Mapping[str, float],
        events: Sequence[Event] = (),
        partitions: Sequence[Partition] = (),
        not_unique: Sequence[str] = (),
        singular: Sequence[SingularPosition] = (),
    ) -> None:
        self.description = description
        self.samples = samples
        self.analysis = analysis
        self.outcome = outcome
        self.message = message
        self.stats = dict(stats)
        self.events = tuple(events)
        self.partitions = tuple(partitions)
        self.works: dict[str, FloatArray] = {}
        self.not_unique = tuple(not_unique)
        self.singular = tuple(singular)
        self.accuracy: ReachedAccuracy | None = None
        self.parameters = {
            row.name: float(value) for row, value in zip(description.parameters, p, strict=False)
        }

    @property
    def failed(self) -> bool:
        """Whether the analysis ended before its end."""
        return self.outcome is not Outcome.OK

    @property
    def t(self) -> FloatArray:
        """Instants in s, shape (k,)."""
        return self.samples.t

    def q(self, name: str) -> FloatArray:
        """A coordinate over time.

        Parameters
        ----------
        name
            Of the coordinate, such as "crank.phi".

        Returns
        -------
        (k,) float64
            In the coordinate's unit, m or rad.

        Raises
        ------
        InputError
            If there is no such coordinate; it names the nearest.
        """
        return self._column(self.samples.q, name, velocity=False)

    def v(self, name: str) -> FloatArray:
        """A velocity over time.

        Parameters
        ----------
        name
            Of the velocity, such as "crank.omega", or of its coordinate.

        Returns
        -------
        (k,) float64
            In m/s or rad/s.
        """
        return self._column(self.samples.v, name)

    def a(self, name: str) -> FloatArray:
        """An acceleration over time.

        Parameters
        ----------
        name
            Of its coordinate or velocity.

        Returns
        -------
        (k,) float64
            In m/s² or rad/s²; not a number in singular configurations.
        """
        return self._column(self.samples.a, name)

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
        if f"{joint}.{component}" in rows.names:
            return self.samples.reaction[:, rows.index(f"{joint}.{component}")]
        of_joint = [row.component for row in rows if row.element == joint]
        if of_joint:
            raise InputError(
                f"{self.description.title}: joint {joint} has no reaction {component!r}; "
                f"it has {', '.join(of_joint)}."
            )
        elements = {*(row.element for row in self.description.constraints)}
        elements |= {*self.description.effects.names}
        if joint in elements and self.description.unasked("reaction", joint):
            raise InputError(self.description.offer(f"reaction({joint})"))
        names = list(dict.fromkeys(row.element for row in rows))
        raise InputError(f"{self.description.title}: {unknown('reaction of', joint, names)}")

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

        Raises
        ------
        InputError
            If there is no such condition.
        """
        return self.samples.modes[:, self._switch(condition)]

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

    def power(self, source: str) -> FloatArray:
        """Power of an effect or driver on the machine.

        Parameters
        ----------
        source
            Name of the effect or driver.

        Returns
        -------
        (k,) float64
            In W.

        Raises
        ------
        InputError
            If there is no such effect or driver, or the scene was declared without its power.
        """
        description, rows = self.description, self.description.powers
        sources = (*description.effects.names, *description.drivers)
        if source in sources and description.unasked("power", source):
            raise InputError(description.offer(f"power({source})"))
        names = [row.name for row in rows if row.kind != "work"]
        if source not in names:
            raise InputError(f"{description.title}: {unknown('power of', source, names)}")
        return self.samples.power[:, rows.index(source)]

    def work(self, source: str) -> FloatArray:
        """Work of an effect or driver on the machine since the start of a simulation.

        The integral of all that it exerts, also of a part that has a potential. Impacts, which
        change velocities at an instant, do no work here; see `runtime.dynamics.work`.

        Parameters
        ----------
        source
            Name of the effect or driver.

        Returns
        -------
        (k,) float64
            In J.

        Raises
        ------
        InputError
            If there is no such effect or driver, the scene was declared without its work, or the
            analysis was no simulation.
        """
        if source in self.works:
            return self.works[source]
        description = self.description
        if source in description.working:
            raise InputError(
                f"{description.title}: work({source}) is integrated along the steps of a "
                f"simulation, and this is a result of {self.analysis}; ask for simulate, or for "
                f"power({source})."
            )
        sources = (*description.effects.names, *description.drivers)
        if source in sources and source not in description.tracked:
            raise InputError(description.offer(f"work({source})"))
        names = description.working or sources
        raise InputError(f"{description.title}: {unknown('work of', source, names)}")

    def path(self, point: str) -> FloatArray:
        """Global coordinates of a tracked point over time.

        Parameters
        ----------
        point
            Name of the tracked point.

        Returns
        -------
        (k, 2) float64
            x and y in m.

        Raises
        ------
        InputError
            If there is no such point, or the scene leaves it out.
        """
        description = self.description
        if point in description.tracked:
            rows = [description.reactions.index(f"{point}.{axis}") for axis in "xy"]
            return self.samples.reaction[:, rows]
        left_out = description.left_out
        if point in left_out.names and left_out[point].kind == "tracked point":
            raise InputError(description.offer(f"path({point})"))
        raise InputError(f"{description.title}: {unknown('path of', point, description.tracked)}")

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
        description = self.description
        if part not in ENERGIES:
            raise InputError(unknown("energy", part, ENERGIES))
        if not description.has_masses:
            raise InputError(f"{description.title} has bodies without mass, so there is no energy.")
        if description.unasked("energy"):
            raise InputError(description.offer("energy"))
        kinetic, potential = self.samples.energy[:, 0], self.samples.energy[:, 1]
        parts = {"kinetic": kinetic, "potential": potential, "total": kinetic + potential}
        return parts[part]

    def series(self, name: str) -> tuple[FloatArray, str]:
        """A column by any of its names, and its unit.

        Parameters
        ----------
        name
            Of a coordinate, a velocity, `a(coordinate)`, `joint.component`, `point.x`, an energy,
            the power of a source, or `work(source)`.

        Returns
        -------
        values : (k,) float64
        unit : str

        Raises
        ------
        InputError
            If there is no such series; it names the nearest.
        """
        description = self.description
        for row in description.coordinates:
            if name == row.name:
                return self.q(name), row.unit
            if name == row.velocity:
                return self.v(name), row.velocity_unit
            if name == f"a({row.name})":
                return self.a(row.name), row.acceleration_unit
        if name in description.reactions.names:
            reaction = description.reactions[name]
            return self.reaction(reaction.element, reaction.component), reaction.unit
        if name in ENERGIES and description.has_masses:
            return self.energy(name), "J"
        if name.startswith("work(") and name[5:-1] in self.works:
            return self.work(name[5:-1]), "J"
        if name in description.powers.names:
            return self.power(name), "W"
        names = [text for row in description.coordinates for text in row[:2]]
        names += description.reactions.names
        raise InputError(f"{description.title}: {unknown('series', name, names)}")

    def about(self) -> dict[str, str]:
        """The run in texts, as files carry it: model, scene, outcome, parameters, versions."""
        return {
            "model": self.description.model,
            "scene": self.description.scene,
            "analysis": self.analysis,
            "outcome": self.outcome.name,
            "message": self.message,
            "parameters": json.dumps(self.parameters),
            "stats": json.dumps(self.stats),
            "not_unique": ", ".join(self.not_unique),
            "singular": json.dumps([row.facts() for row in self.singular]),
            **({"accuracy": json.dumps(self.accuracy.facts())} if self.accuracy else {}),
            "linkwright": __version__,
            "generator": self.description.generator,
            "numpy": np.__version__,
        }

    def _switch(self, condition: str) -> int:
        switches = self.description.switches
        full = [row.title for row in switches]
        if condition in full:
            return full.index(condition)
        of_effect = [k for k, row in enumerate(switches) if row.name == condition]
        if len(of_effect) == 1:
            return of_effect[0]
        raise InputError(f"{self.description.title}: {unknown('condition', condition, full)}")

    def _column(self, array: FloatArray, name: str, *, velocity: bool = True) -> FloatArray:
        table = self.description.coordinates
        for index, row in enumerate(table):
            if name == row.name or (velocity and name == row.velocity):
                return array[:, index]
        names = [*table.names, *(row.velocity for row in table if velocity)]
        raise InputError(f"{self.description.title}: {unknown('coordinate', name, names)}")

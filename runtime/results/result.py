"""What an analysis returns: arrays over time, how the run went, and how it ended."""

import json
import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen import __version__
from codegen.errors import InputError
from runtime.mechanism.description import Description, unknown
from runtime.core.outcomes import Outcome
from runtime.results.samples import Samples
from runtime.results.singular_positions import SingularPosition

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from runtime.studies.accuracy_target import ReachedAccuracy
    from runtime.machine import Machine

FloatArray = npt.NDArray[np.float64]
ENERGIES = ("kinetic", "potential", "total")


class Result:
    """Motion of a machine at the instants `t`.

    Attributes
    ----------
    samples
        The arrays, one row an instant.
    outcome
        How the analysis ended; `message` says it in full, with time and joint.
    stats
        Counts of what the analysis did, and its wall time in s.
    events
        What happened between the instants.
    partitions
        The independent coordinates of a simulation: the first choice, then every change.
    not_unique
        Joints and drivers whose reactions redundant constraints leave open; those of least norm are
        given.
    singular
        The singular positions that the run met, in order.
    accuracy
        Of a simulation that was asked for one, what it reached and how that is known.
    parameters
        Parameter values by name.
    """

    def __init__(
        self,
        machine: "Machine",
        samples: Samples,
        p: FloatArray,
        *,
        analysis: str,
        outcome: Outcome,
        message: str,
        stats: Mapping[str, float],
        events: Sequence[Any] = (),
        partitions: Sequence[Any] = (),
        not_unique: Sequence[str] = (),
        singular: Sequence[SingularPosition] = (),
    ) -> None:
        self.description: Description = machine.description
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
            row.name: float(value) for row, value in zip(machine.parameters, p, strict=False)
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
        """A coordinate over time, in its unit, shape (k,)."""
        return self._column(self.samples.q, name, velocity=False)

    def v(self, name: str) -> FloatArray:
        """A velocity over time, by its own name or its coordinate's, shape (k,)."""
        return self._column(self.samples.v, name)

    def a(self, name: str) -> FloatArray:
        """An acceleration over time, by the name of its coordinate or velocity, shape (k,)."""
        return self._column(self.samples.a, name)

    def reaction(self, joint: str, component: str) -> FloatArray:
        """What the first body of a joint exerts on the second, in joint axes, shape (k,).

        Of a driver: what it exerts on the body that it drives. In N or N m.
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
        """Mode of a switching condition over time, shape (k,).

        1 where it held, 0 where it did not, 2 where its function stays at zero: the motion slides
        there, friction sticks, or a rigid contact is closed. Named as in events, such as
        "gas: slider_vx > 0", or by its effect where that has one condition only.
        """
        return self.samples.modes[:, self._switch(condition)]

    def share(self, condition: str) -> FloatArray:
        """Share α of the force of mode 1 with which a condition is held, NaN elsewhere, (k,).

        There the accelerations are (1 - α) times those without the condition plus α times those
        with it. A rigid contact has 1 where its force vanishes; what it exerts is its reaction.
        Named as in `mode`.
        """
        return self.samples.share[:, self._switch(condition)]

    def power(self, source: str) -> FloatArray:
        """Power of an effect or driver on the machine in W, shape (k,)."""
        rows = self.description.powers
        sources = (*self.description.effects.names, *self.description.drivers)
        if source in sources and self.description.unasked("power", source):
            raise InputError(self.description.offer(f"power({source})"))
        names = [row.name for row in rows if row.kind != "work"]
        if source not in names:
            raise InputError(f"{self.description.title}: {unknown('power of', source, names)}")
        return self.samples.power[:, rows.index(source)]

    def work(self, source: str) -> FloatArray:
        """Work of an effect or driver on the machine since the start in J, shape (k,).

        Of all that it exerts, what has a potential included; impacts do none of it. See
        `runtime.dynamics.work`.
        """
        if source in self.works:
            return self.works[source]
        told = self.description
        if source in told.working:
            raise InputError(
                f"{told.title}: work({source}) is integrated along the steps of a simulation, and "
                f"this is a result of {self.analysis}; ask for simulate, or for power({source})."
            )
        sources = (*told.effects.names, *told.drivers)
        if source in sources and source not in told.tracked:
            raise InputError(told.offer(f"work({source})"))
        raise InputError(f"{told.title}: {unknown('work of', source, told.working or sources)}")

    def path(self, point: str) -> FloatArray:
        """Global coordinates of a tracked point in m, shape (k, 2)."""
        told = self.description
        if point in told.tracked:
            rows = [told.reactions.index(f"{point}.{axis}") for axis in "xy"]
            return self.samples.reaction[:, rows]
        if point in told.left_out.names and told.left_out[point].kind == "tracked point":
            raise InputError(told.offer(f"path({point})"))
        raise InputError(f"{told.title}: {unknown('path of', point, told.tracked)}")

    def energy(self, part: str = "total") -> FloatArray:
        """Kinetic, potential or total energy in J, shape (k,)."""
        if part not in ENERGIES:
            raise InputError(unknown("energy", part, ENERGIES))
        if not self.description.has_masses:
            raise InputError(
                f"{self.description.title} has bodies without mass, so there is no energy."
            )
        if self.description.unasked("energy"):
            raise InputError(self.description.offer("energy"))
        kinetic, potential = self.samples.energy[:, 0], self.samples.energy[:, 1]
        parts: dict[str, FloatArray] = {
            "kinetic": kinetic,
            "potential": potential,
            "total": kinetic + potential,
        }
        return parts[part]

    def series(self, name: str) -> tuple[FloatArray, str]:
        """A column by any of its names, and its unit.

        A coordinate, a velocity, `a(coordinate)`, `joint.component`, `point.x`, an energy, the
        power of a source, or `work(source)`.
        """
        told = self.description
        for row in told.coordinates:
            if name == row.name:
                return self.q(name), row.unit
            if name == row.velocity:
                return self.v(name), f"{row.unit}/s"
            if name == f"a({row.name})":
                return self.a(row.name), f"{row.unit}/s^2"
        if name in told.reactions.names:
            reaction = told.reactions[name]
            return self.reaction(reaction.element, reaction.component), reaction.unit
        if name in ENERGIES and told.has_masses:
            return self.energy(name), "J"
        if name.startswith("work(") and name[5:-1] in self.works:
            return self.work(name[5:-1]), "J"
        if name in told.powers.names:
            return self.power(name), "W"
        names = [text for row in told.coordinates for text in row[:2]]
        raise InputError(
            f"{told.title}: {unknown('series', name, [*names, *told.reactions.names])}"
        )

    @cached_property
    def data(self) -> "xr.Dataset":
        """Everything as an xarray.Dataset, units in the attributes."""
        from runtime.results.dataset import dataset

        return dataset(self)

    def about(self) -> dict[str, str]:
        """What a file says about the run that it holds; texts only."""
        told = self.description
        return {
            "model": told.model,
            "scene": told.scene,
            "analysis": self.analysis,
            "outcome": self.outcome.name,
            "message": self.message,
            "parameters": json.dumps(self.parameters),
            "stats": json.dumps(self.stats),
            "not_unique": ", ".join(self.not_unique),
            "singular": json.dumps([row.facts() for row in self.singular]),
            **({"accuracy": json.dumps(self.accuracy.facts())} if self.accuracy else {}),
            "linkwright": __version__,
            "generator": told.generator,
            "numpy": np.__version__,
        }

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write to a .nc, .csv, .parquet or .html file, whole or not at all; returns the path."""
        from runtime.results.files import save

        return save(self, Path(path))

    def plot(self, *names: str) -> "Figure":
        """Picture of series over time (coordinates that are angles if none are named)."""
        from runtime.show.plot import plot

        return plot(self, names)

    def __repr__(self) -> str:
        """One line for a person, and how it ended."""
        count = len(self.t)
        ends = f" to {self.t[-1]:g}" if count > 1 else ""
        span = f"t = {self.t[0]:g}{ends} s" if count else "nothing computed"
        return (
            f"{self.description.title}, {self.analysis}: "
            f"{count} instant{'' if count == 1 else 's'}, {span}\n"
            f"  {self.outcome.name}: {self.message}"
        )

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

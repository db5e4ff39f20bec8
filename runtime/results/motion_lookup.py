"""Series of a result's motion by name: coordinates, velocities, accelerations, points."""

from collections.abc import Callable, Iterable
from functools import wraps
from typing import Concatenate, ParamSpec, TypeVar

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.plain_values import is_a, shown
from codegen.public_callables import checked_class
from runtime.mechanism.module_tables import Description
from runtime.mechanism.table_rows import TRACKED, unknown
from runtime.results.samples import Samples

FloatArray = npt.NDArray[np.float64]
Names = ParamSpec("Names")
Column = TypeVar("Column")
POINT = "x", "y", "vx", "vy"  # components of a tracked point
Series = TypeVar("Series", bound="MotionSeries")
Lookup = Callable[Concatenate[Series, Names], Column]


def by_names(lookup: Lookup[Series, Names, Column]) -> Lookup[Series, Names, Column]:
    """A lookup that refuses arguments that are no texts."""

    @wraps(lookup)
    def checked(result: Series, /, *names: Names.args, **keywords: Names.kwargs) -> Column:
        for name in (*names, *keywords.values()):
            if not is_a(name, str):
                raise InputError(
                    f"{result.description.title}: {lookup.__name__}({shown(name)}): a name is "
                    f"a text, such as {result.description.coordinates.names[0]!r} of a coordinate."
                )
        return lookup(result, *names, **keywords)

    return checked


@checked_class
class MotionSeries:
    """Samples of a motion, with the tables that name them."""

    description: Description
    samples: Samples

    @by_names
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
        """
        return self._column(self.samples.q, name, velocity=False)

    @by_names
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

    @by_names
    def a(self, name: str) -> FloatArray:
        """An acceleration over time.

        Parameters
        ----------
        name
            Of its coordinate or velocity, or of a state, whose rate it then is.

        Returns
        -------
        (k,) float64
            In m/s² or rad/s², or the unit of a state per second; not a number in singular
            configurations.
        """
        return self._column(self.samples.a, name)

    @by_names
    def y(self, name: str) -> FloatArray:
        """A first-order state, a sampled value or a latch over time.

        Parameters
        ----------
        name
            Of the state, such as "current".

        Returns
        -------
        (k,) float64
            In the state's unit; of a latch 1 where it holds, else 0. `a` has the rate of a state.

        Raises
        ------
        InputError
            If the scene has no such state.
        """
        states = self.description.states
        if name not in states.names:
            raise self._unknown("state", name, states.names)
        return self.samples.v[:, states[name].column]

    @by_names
    def point(self, name: str, component: str = "") -> FloatArray:
        """Place of a tracked point over time, in global axes.

        Parameters
        ----------
        name
            Of the point.
        component
            "x" or "y", in m, or "vx" or "vy", in m/s; without it, x and y.

        Returns
        -------
        (k, 2) or, of a component, (k,) float64

        Raises
        ------
        InputError
            If there is no such point or component, or the scene leaves it out.
        """
        description = self.description
        if name in description.tracked:
            if component and component not in POINT:
                raise InputError(
                    f"{description.title}: {unknown(f'component of {name}', component, POINT)}"
                )
            if component:
                row = description.reactions.index(f"{name}.{component}")
                return self.samples.reaction[:, row]
            return np.column_stack([self.point(name, axis) for axis in "xy"])
        left_out = description.left_out
        if name in left_out.names and left_out[name].kind == TRACKED:
            raise InputError(description.suggest_output(f"point({name})"))
        raise self._unknown("tracked point", name, description.tracked)

    def _column(self, array: FloatArray, name: str, *, velocity: bool = True) -> FloatArray:
        table = self.description.coordinates
        for index, row in enumerate(table):
            if name == row.name or (velocity and name == row.velocity):
                return array[:, index]
            if name == row.velocity:
                word, letter = ("state", "y") if row.is_state else ("velocity", "v")
                raise InputError(
                    f"{self.description.title}: There is no coordinate {name!r}: it is a {word}; "
                    f"ask for {letter}({name!r})."
                )
        rows = self.description.positions
        names = [row.name for row in rows] + [row.velocity for row in rows if velocity]
        raise self._unknown("coordinate", name, names)

    def _unknown(self, kind: str, name: str, names: Iterable[str]) -> InputError:
        return InputError(f"{self.description.title}: {unknown(kind, name, names)}")

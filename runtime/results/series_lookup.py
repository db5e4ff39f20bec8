"""Series of a result by name."""

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from codegen.errors import InputError
from codegen.readers.calls import checked_class
from codegen.readers.quantities import converted, converts, unit_text
from codegen.readers.values import shown
from runtime.mechanism.module_tables import Description
from runtime.mechanism.series_table import Series, SeriesTable, UnnamedOutputError
from runtime.mechanism.spins import axes_and_angles, rotation_matrices, spins
from runtime.results.samples import FloatArray, Samples

if TYPE_CHECKING:
    from runtime.results.result import Result

Column = npt.NDArray[Any]


@checked_class
class TimeSeries:
    """Samples of a motion, with the tables that name them; see `Result`.

    Each method returns float64 values, one a sample, (k,), in SI units or in the `unit` that is
    asked for, such as "mm", "deg", "rpm" or "kN". What the scene's outputs do not name, but for
    works, is computed from the states on demand. A name or component that the scene does not have
    is refused by an `InputError` with the nearest ones, and so is a unit that does not fit.
    """

    description: Description
    samples: Samples
    works: dict[str, FloatArray]
    analysis: str

    def __getitem__(self, name: str) -> FloatArray:
        """A column by any of its names, in SI units, as in `series`."""
        return self.series(name)[0]

    def q(self, name: str, unit: str = "") -> FloatArray:
        """A coordinate over time, m or rad, by its name, such as "crank.phi"."""
        return self._called("q", name, unit=unit)

    def v(self, name: str, unit: str = "") -> FloatArray:
        """A velocity over time, m/s or rad/s, by its name, "crank.omega", or its coordinate's."""
        return self._called("v", name, unit=unit)

    def a(self, name: str, unit: str = "") -> FloatArray:
        """An acceleration over time, m/s² or rad/s², by the name of its coordinate or velocity.

        The name of a state returns the rate of the state, in its unit per second. In singular
        configurations the values are nan.
        """
        return self._called("a", name, unit=unit)

    def y(self, name: str, unit: str = "") -> FloatArray:
        """A first-order state, a sampled value or a latch over time, by its name, in its unit.

        A latch is 1 where it holds, else 0. `a` has the rate of a state.
        """
        return self._called("y", name, unit=unit)

    def point(self, name: str, component: str = "", unit: str = "") -> FloatArray:
        """A tracked point over time, in global axes: "x" or "y", in m, or "vx" or "vy", in m/s.

        "ax" and "ay" are its acceleration, m/s². Without a component it is x and y, (k, 2). In
        space there are "z", "vz" and "az", too, and without a component it is (k, 3).
        """
        if component:
            return self._called("point", name, component, unit)
        axes = "xyz" if self.description.turning else "xy"
        return np.column_stack([self._called("point", name, axis, unit) for axis in axes])

    def rotation(self, body: str) -> FloatArray:
        """Rotation matrix of a body in space over time, (k, 3, 3), from its axes to global ones.

        An `InputError` says so of any other body. "rod.Axx" to "rod.Azz" are series.
        """
        first = self._first_parameter(body)
        return rotation_matrices(self.samples.q[:, first : first + 4])

    def axis_angle(self, body: str) -> tuple[FloatArray, FloatArray]:
        """Axis, (k, 3), and angle, (k,), rad, of a body's rotation from the global axes over time.

        The angle is between 0 and π at the first sample. From sample to sample it is counted
        through turns, and the axis keeps its sense. A body that stands as the global axes do, also
        after whole turns, has no axis: that of the sample before holds, else the first one that
        follows, else z. A body that turns by half a turn from one sample to the next is refused.
        """
        first, t = self._first_parameter(body), self.samples.t
        p, rates = (x[:, first : first + 4] for x in (self.samples.q, self.samples.v))
        speed = np.linalg.norm(spins(p, rates), axis=1)
        turned = np.abs(np.diff(t)) * 0.5 * (speed[1:] + speed[:-1])
        for k in np.flatnonzero(turned >= np.pi)[:1]:
            raise InputError(
                f"{self.description.title}: '{body}' turns by about {turned[k]:.3g} rad between t "
                f"= {t[k]:.6g} and {t[k + 1]:.6g} s, and turns are counted from samples less than "
                "half a turn apart; ask for more instants, t_eval=1001 or result.at(...)."
            )
        return axes_and_angles(p)

    def _first_parameter(self, body: str) -> int:
        """The column of e0 of a body in space."""
        for name, first in self.description.turning:
            if name == body:
                return first
        names = ", ".join(name for name, _ in self.description.turning) or "none here"
        raise InputError(
            f"{self.description.title}: {shown(body)} is no body in space, which are {names}."
        )

    def wrench(self, joint: str, on: str, at: Any = (0, 0, 0), axes: str = "ground") -> FloatArray:
        """Force and torque of a joint or driver on a body in space over time, (k, 6), N and N m.

        Parameters
        ----------
        joint, on
            Its name, and that of the body on which it acts, or "ground".
        at
            Where the torque is taken: a place in the frame of `on`, m, by default the centre of
            mass; or the name of a tracked point of any body.
        axes
            The body in whose axes the components are; by default the global ones.
        """
        from runtime.dynamics.outputs_afterwards import joint_wrench  # which stands above

        return joint_wrench(cast("Result", self), joint, on, at, axes)

    def reaction(self, joint: str, component: str, unit: str = "") -> FloatArray:
        """Force or torque that the first body of a joint exerts on the second, in joint axes.

        In space the axes are global, and the components "fx" to "fz" and "tx" to "tz"; `wrench`
        has them at other points and in other axes.

        For a driver it is the force or torque on the body that it drives. Components are such as
        "fx", "fy" and "torque", in N or N m; "global_fx" and "global_fy" are the force in global
        axes. That of "ground" is what the machine exerts on it: the force and its moment about the
        origin, in global axes.
        """
        return self._called("reaction", joint, component, unit)

    def mode(self, condition: str) -> npt.NDArray[np.int64]:
        """Mode of a switching condition over time, (k,) int64.

        It is 1 where the condition held, 0 where it did not, and 2 where its function stayed at
        zero: the motion slid on the switching surface, friction stuck, or a rigid contact was
        closed. The condition has its name in events, "gas: slider_vx > 0", or that of an effect
        with one condition only.
        """
        return self._called("mode", condition)

    def share(self, condition: str) -> FloatArray:
        """Filippov's share α of a condition over time, from 0 to 1, where its mode is 2.

        There the accelerations are (1 - α) times those without the condition plus α times those
        with it. For a rigid contact α is 1 where its force vanishes; `reaction` returns this force.
        The share is nan where the mode is 0 or 1, or where every share is possible. The condition
        is named as in `mode`.
        """
        return self._called("share", condition)

    def energy(self, part: str = "total", unit: str = "") -> FloatArray:
        """Energy over time, J: its "kinetic" or "potential" part, or the "total".

        Without masses there is no energy, and the call raises an `InputError`.
        """
        return self._called("energy", part, unit=unit)

    def force(self, effect: str, component: str = "", unit: str = "") -> FloatArray:
        """Force of an effect over time, N, an output ``force(NAME)`` of the scene.

        A spring, damper or actuator has its tension, positive where it pulls its ends together; a
        contact the force that pushes its bodies apart, positive; a friction the force along its
        slip, and "normal" and "limit"; a clearance joint "normal", which pushes, and "friction" on
        the journal, counter-clockwise about the bearing; an applied force "fx" and "fy" in the axes
        in which it is given; a bushing "fx" and "fy" on its second body, in the axes of the first;
        gears with backlash and elastic belts "first" and "second" for each flank or strand, as
        has a stop for its lower and its upper limit; any other effect its generalized forces by
        coordinate, "bob.x". The name of a joint or driver returns its reaction.
        """
        return self._called("force", effect, component, unit)

    def torque(self, effect: str, component: str = "", unit: str = "") -> FloatArray:
        """Torque of an effect over time, N m, an output ``torque(NAME)`` of the scene.

        The torque of a torsion spring acts on its first body, of a bushing on its second, of a
        motor on its rotor; of a one-way clutch on its driven body, from 0 to the capacity; of a
        friction in a revolute joint along its slip. A stop of an angle has the torque away from the
        limit, positive. Any other effect has its generalized forces on angles, "bob.phi".
        """
        return self._called("torque", effect, component, unit)

    def length(self, effect: str, unit: str = "") -> FloatArray:
        """Length of a spring or damper over time, in m; an output ``length(NAME)``."""
        return self._called("length", effect, unit=unit)

    def angle(self, effect: str, unit: str = "") -> FloatArray:
        """Angle φ_j - φ_i of a torsion spring over time, in rad; an output ``angle(NAME)``."""
        return self._called("angle", effect, unit=unit)

    def rate(self, effect: str, component: str = "", unit: str = "") -> FloatArray:
        """Rate of a length, an angle or a gap, or the slip of a friction, in m/s or rad/s.

        An output ``rate(NAME)`` of the scene. A bushing has the components "x", "y" and "phi".
        """
        return self._called("rate", effect, component, unit)

    def deflection(self, effect: str, component: str = "", unit: str = "") -> FloatArray:
        """Length minus free length of a spring, or angle minus free angle, in m or rad.

        An output ``deflection(NAME)`` of the scene. A bushing has the components "x", "y" and
        "phi", in the axes of its first body.
        """
        return self._called("deflection", effect, component, unit)

    def gap(self, effect: str, component: str = "", unit: str = "") -> FloatArray:
        """Gap of a contact over time, in m, negative in penetration; ``gap(NAME)``.

        Gears with backlash and elastic belts have two, "first" and "second".
        """
        return self._called("gap", effect, component, unit)

    def penetration(self, effect: str, component: str = "", unit: str = "") -> FloatArray:
        """Penetration of a contact that yields, in m, 0 where it is open; ``penetration(NAME)``."""
        return self._called("penetration", effect, component, unit)

    def potential(self, effect: str, unit: str = "") -> FloatArray:
        """Potential energy of an effect over time, in J; an output ``potential(NAME)``."""
        return self._called("potential", effect, unit=unit)

    def power(self, source: str, part: str = "whole", unit: str = "") -> FloatArray:
        """Power of an effect or driver on the machine, W.

        "whole" is the power of all its forces. "nonconservative" leaves out those of its potential;
        this part, such as that of a damper, changes the energy of the machine.
        """
        return self._called("power", source, part, unit)

    def work(self, source: str, unit: str = "") -> FloatArray:
        """Work of an effect or driver on the machine since the start of a simulation, J.

        It is the integral of the "whole" `power`. Impacts, which change velocities in an instant,
        do no work here; see `runtime.dynamics.output_quantities`. An `InputError` says so if the
        scene was declared without this work, or the analysis was no simulation.
        """
        return self._called("work", source, unit=unit)

    def series(self, name: str, unit: str = "") -> tuple[FloatArray, str]:
        """A column by any of its names, and its unit.

        Parameters
        ----------
        name
            Of a coordinate, a velocity, a state, `a(coordinate)`, `a(state)`, `joint.component`,
            `point.x`, `kinetic energy`, `power(source)`, `work(source)`, or another column of
            `to_pandas`; of an effect `strut.force` or `force(strut)`, and so on for lengths, rates
            and the like.

        Returns
        -------
        values : (k,) float64
        unit : str
        """
        return self._found(lambda table: table.find(name), unit)

    def column(self, row: Series) -> Column:
        """The values of a series of `Description.series`, (k,)."""
        if row.array == "works":
            if row.element not in self.works:
                raise InputError(
                    f"{self.description.title}: {row.name} is integrated along the steps of a "
                    f"simulation, and this is a result of {self.analysis}; ask for simulate, or "
                    f"for power({row.element})."
                )
            return self.works[row.element]
        return self.samples.column(row)

    def _called(self, word: str, name: str, component: str = "", unit: str = "") -> Column:
        return self._found(lambda table: table.call(word, name, component), unit)[0]

    @cached_property
    def _afterwards(self) -> "list[tuple[slice, Description, Samples]]":
        from runtime.dynamics.outputs_afterwards import outputs_afterwards  # which stands above

        return outputs_afterwards(cast("Result", self))

    def _found(self, find: Callable[[SeriesTable], Series], unit: str) -> tuple[Column, str]:
        """Values, (k,), and their unit; what does not act in a part exerts nothing there."""
        row: Series | None = None
        try:
            row = find(self.description.series)
            values = self.column(row)
        except UnnamedOutputError as error:
            refusal, values = cast(InputError, error), np.zeros(len(self.samples.t))
            for rows, description, samples in self._afterwards:
                try:
                    row = find(description.series)
                    values[rows] = samples.column(row)
                except InputError as other:
                    refusal = other
            if row is None:
                raise refusal from None
        if not (unit := unit_text(unit)):
            return values, row.unit
        if not converts(row.unit, unit):
            raise InputError(
                f"{self.description.title}: {row.name} is in {row.unit or 'no unit'}, which does "
                f"not convert to {shown(unit)}; ask for a unit of its dimension"
                f"{' (rpm or deg/s, and not Hz)' if row.unit == 'rad/s' else ''}."
            )
        return np.asarray(converted(values, row.unit, unit)), unit

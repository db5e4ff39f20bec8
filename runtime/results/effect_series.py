"""Series of the effects of a result by name: forces, lengths, rates, potentials, powers, works."""

from codegen.errors import InputError
from codegen.public_callables import checked_class
from runtime.mechanism.table_rows import ReactionRow, unknown
from runtime.results.motion_lookup import FloatArray, MotionSeries, by_names

QUANTITIES = (
    "force", "torque", "length", "angle", "rate", "deflection", "gap", "penetration", "potential",
)  # fmt: skip
"""Quantities of effects that a scene may name as outputs, ``force(strut)``."""
_BY_UNIT = {"N": "force", "N m": "torque"}
PARTS = ("whole", "nonconservative")


def quantity_of(row: ReactionRow) -> str:
    """The quantity that a row of an effect is a component of; empty for others."""
    word = row.component.partition(".")[0]
    return word if word in QUANTITIES else _BY_UNIT.get(row.unit, "")


@checked_class
class EffectSeries(MotionSeries):
    """What the effects of a result exert, how far they are deflected, and the work that they do."""

    works: dict[str, FloatArray]
    analysis: str

    @by_names
    def force(self, effect: str, component: str = "") -> FloatArray:
        """Force of an effect over time, an output ``force(NAME)`` of the scene.

        Of a spring, damper or actuator the tension, positive where it pulls its ends together; of a
        contact the force that pushes its bodies apart, positive; of a friction the force along its
        slip; of a joint with clearance "normal", which pushes, and "friction" on the journal,
        counter-clockwise about the bearing; of an applied force its components "fx" and "fy" in the
        axes in which it is given; of a bushing "fx" and "fy" on its second body, in the axes of the
        first; of gears with backlash and of elastic belts "first" and "second" for each flank or
        strand; of any other effect the generalized forces by coordinate, "bob.x".

        Parameters
        ----------
        effect
            Its name; that of a joint or driver means its reaction.
        component
            Where there are several; "normal" and "limit" of a friction.

        Returns
        -------
        (k,) float64
            In N.

        Raises
        ------
        InputError
            If there is no such effect or component, or the scene was declared without it.
        """
        return self._measure("force", effect, component)

    @by_names
    def torque(self, effect: str, component: str = "") -> FloatArray:
        """Torque of an effect over time, an output ``torque(NAME)`` of the scene.

        Of a torsion spring that on its first body, of a bushing that on its second, of a motor that
        on its rotor; of a one-way clutch that on its driven body, from 0 to the capacity; of a
        friction in a revolute joint that along its slip; of a stop of an angle that which pushes
        away from the limit, positive; of an effect without a torque of its own the
        generalized forces on angles, "bob.phi". Arguments and errors are those of `force`; in N m.
        """
        return self._measure("torque", effect, component)

    @by_names
    def length(self, effect: str) -> FloatArray:
        """Length of a spring or damper over time, in m; an output ``length(NAME)``."""
        return self._measure("length", effect)

    @by_names
    def angle(self, effect: str) -> FloatArray:
        """Angle φ_j - φ_i of a torsion spring over time, in rad; an output ``angle(NAME)``."""
        return self._measure("angle", effect)

    @by_names
    def rate(self, effect: str, component: str = "") -> FloatArray:
        """Rate of a length, an angle or a gap, or the slip of a friction, in m/s or rad/s.

        An output ``rate(NAME)`` of the scene. A bushing has the components "x", "y" and "phi".
        """
        return self._measure("rate", effect, component)

    @by_names
    def deflection(self, effect: str, component: str = "") -> FloatArray:
        """Length less free length of a spring, or angle less free angle, in m or rad.

        An output ``deflection(NAME)`` of the scene. A bushing has the components "x", "y" and
        "phi", in the axes of its first body.
        """
        return self._measure("deflection", effect, component)

    @by_names
    def gap(self, effect: str, component: str = "") -> FloatArray:
        """Gap of a contact over time, in m, negative where it is penetrated; ``gap(NAME)``.

        Gears with backlash and elastic belts have two, "first" and "second".
        """
        return self._measure("gap", effect, component)

    @by_names
    def penetration(self, effect: str, component: str = "") -> FloatArray:
        """Penetration of a contact that yields, in m, 0 where it is open; ``penetration(NAME)``."""
        return self._measure("penetration", effect, component)

    @by_names
    def potential(self, effect: str) -> FloatArray:
        """Potential energy of an effect over time, in J; an output ``potential(NAME)``."""
        return self._measure("potential", effect)

    @by_names
    def power(self, source: str, part: str = "whole") -> FloatArray:
        """Power of an effect or driver on the machine.

        Parameters
        ----------
        source
            Name of the effect or driver.
        part
            "whole": of all that it exerts; of an effect with a potential it has to be an output,
            ``power(NAME)`` or ``powers``. "nonconservative": less the forces of its potential, such
            as the damper of a spring, which changes the energy of the machine.

        Returns
        -------
        (k,) float64
            In W.

        Raises
        ------
        InputError
            If there is no such effect or driver, or the scene was declared without its power.
        """
        description, title = self.description, self.description.title
        if part not in PARTS:
            raise InputError(f"{title}: {unknown('part of a power', part, PARTS)}")
        rows = {row.name: k for k, row in enumerate(description.powers)}
        whole, column = description.whole_powers, None
        if part == "whole":
            column = whole.get(source)
        elif source in rows:
            column = rows[source]
        if column is not None:
            return self.samples.power[:, column]
        if source in self._sources:
            self._require_output("power", source)
            if part == "nonconservative":
                raise InputError(
                    f"{title}: '{source}' has no forces without a potential; power({source!r}) is "
                    "that of its potential."
                )
            raise InputError(description.suggest_output(f"power({source})"))
        raise self._unknown("power of", source, self._sources)

    @by_names
    def work(self, source: str) -> FloatArray:
        """Work of an effect or driver on the machine since the start of a simulation.

        The integral of its `power`, of all that it exerts. Impacts, which change velocities at an
        instant, do no work here; see `runtime.dynamics.work`.

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
        if source in description.work_rows:
            raise InputError(
                f"{description.title}: work({source}) is integrated along the steps of a "
                f"simulation, and this is a result of {self.analysis}; ask for simulate, or for "
                f"power({source})."
            )
        if source in self._sources:
            raise InputError(description.suggest_output(f"work({source})"))
        raise self._unknown("work of", source, description.work_rows or self._sources)

    @property
    def _sources(self) -> tuple[str, ...]:
        """Effects and drivers, which may have power and do work."""
        description = self.description
        effects = (name for name in description.effects.names if name not in description.tracked)
        return (*effects, *description.drivers)

    def _measure(self, quantity: str, effect: str, component: str = "") -> FloatArray:
        return self.samples.reaction[:, self._row_of(quantity, effect, component)]

    def _row_of(self, quantity: str, effect: str, component: str = "") -> int:
        """The column of a quantity of an effect among the reactions."""
        description = self.description
        every = [(k, row) for k, row in enumerate(description.reactions) if row.element == effect]
        found = {row.component: k for k, row in every if quantity_of(row) == quantity}
        asked = f"{quantity}.{component}" if f"{quantity}.{component}" in found else component
        if not asked and (quantity in found or len(found) == 1):
            asked = quantity if quantity in found else next(iter(found))
        if asked in found:
            return found[asked]
        if found:
            names = (name.removeprefix(f"{quantity}.") for name in found)
            ways = ", ".join(f"{quantity}({effect!r}, {name!r})" for name in names)
            what = f"several components of {quantity}"
            what = f"no {quantity} {component!r}" if component else what
            raise InputError(f"{description.title}: {effect} has {what}; ask for {ways}.")
        if effect in {row.element for row in description.constraints}:
            self._require_output("reaction", effect)
            others = ", ".join(f"reaction({effect!r}, {row.component!r})" for _, row in every)
            raise InputError(
                f"{description.title}: '{effect}' is a joint or driver"
                + (f"; ask for {others}." if others else ", and transmits none.")
            )
        acting = [name for name in description.effects.names if name not in description.tracked]
        if effect in acting:
            outputs = {*(description.outputs or ())}
            if not outputs & {f"{quantity}s", f"{quantity}({effect})"}:
                raise InputError(description.suggest_output(f"{quantity}({effect})"))
            known = dict.fromkeys(word for _, row in every if (word := quantity_of(row)))
            has = f"it has {', '.join(known)}" if known else "and the scene asks for nothing of it"
            raise InputError(f"{description.title}: '{effect}' has no {quantity}; {has}.")
        if effect in description.left_out.names:
            raise InputError(
                f"{description.title}: '{effect}' does not act in this scene; load "
                f"scene.with_({effect!r}, outputs=['default', '{quantity}({effect})'])."
            )
        raise self._unknown(f"{quantity} of", effect, acting)

    def _require_output(self, output: str, *element: str) -> None:
        """Refuse an output that the scene was declared without."""
        if self.description.leaves_out(output, *element):
            named = f"{output}({element[0]})" if element else output
            raise InputError(self.description.suggest_output(named))

"""The numbers of a declaration: parameters, tables, files of data, states, sampled values."""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args
from warnings import warn

import sympy

from codegen.declare.element_fields import sign_conditions
from codegen.declare.state import Clock, State, Trigger
from codegen.declare.symbols import Parameter, ParameterDeclaration, SignRule, Velocity
from codegen.errors import TableWarning
from codegen.model.base import Declarations
from codegen.readers import quantities
from codegen.readers.quantities import converted, known_unit, si_factor, si_unit
from codegen.readers.values import one_line, shown
from codegen.tables.period import misfit, with_closing_row
from codegen.tables.piecewise_cubic import Beyond, Ends, Kind, Table, excess, fit
from codegen.tables.table_function import FEWEST, TableFunction, point_problems

_EXCESS = 0.05  # safety: of the range of the data; a curve that exceeds it by more oscillates

ZERO = sympy.S.Zero
KINDS, BEYOND, ENDS = get_args(Kind), get_args(Beyond), get_args(Ends)


def _warn_of_excess(table: Table, low: float, high: float) -> None:
    """Say that a curve swings out of the range of its data."""
    found = excess(table)
    if found is not None and found.share > _EXCESS:
        warn(
            f"table '{table.name}': the {table.kind} leaves the range of its data, {low:g} to "
            f"{high:g}, by {100 * found.share:.3g} % of it: it is {found.value:.6g} at "
            f"{found.at:.6g}; give kind='pchip', which stays inside, or more points.",
            TableWarning,
            stacklevel=5,
        )


def _unused(periodic: bool, kind: str, beyond: str, ends: str) -> Iterator[str]:
    """Arguments that say nothing of such a table."""
    if periodic and beyond != "stop":
        yield f"it repeats, so that nothing is beyond its ends; leave out beyond={beyond!r}."
    if ends != "not-a-knot" and (periodic or kind != "spline"):
        why = "it repeats" if periodic else f"one of kind {kind!r} asks for no condition there"
        yield f"ends={ends!r} is of splines that do not repeat, and {why}; leave it out."


def are_units(units: Any) -> bool:
    """Whether they are two units, of which zero is zero in SI."""
    known = isinstance(units, tuple | list) and len(units) == 2 and all(map(known_unit, units))
    return known and all(math.isfinite(si_factor(unit)) for unit in units)


class Values(Declarations):
    """The parameters, tables and data files of a declaration."""

    def parameter(self, name: str, value: Any, unit: str = "", sign: SignRule = "") -> Parameter:
        """A number that runs may change without a new build.

        Parameters
        ----------
        value
            The default: a number in `unit`, or a text such as ``"45 mm"`` or a pint quantity that
            converts to it; without `unit`, the unit of the text counts.
        unit
            Such as ``"kg m^2"`` or ``"mm"``; empty for a pure number. It is the unit of this number
            alone: equations, results and numbers given at run time are in SI.
        sign
            A rule that every value must obey; masses and inertias are positive by themselves.
        """
        symbol = Parameter(str(name), real=True)
        where = f"parameter '{name}'"
        label: object = quantities.unit_text(unit)
        unit = " ".join(label.split()) if isinstance(label, str) else unit
        if unit == "" and isinstance(value, str):
            unit = ((quantities.QUANTITY.fullmatch(value) or ["", "", ""])[2] or "").strip()
        sign = self._read.choice(sign, ("", "positive", "nonnegative"), f"{where}, sign")
        if not known_unit(unit):
            what = shown(unit)
            such = "'mm', 'N m' or 'rpm'"
            self._note(f"{where}: the unit {what} is not known; write one such as {such}.")
            unit = ""
        elif math.isnan(si_factor(unit)):
            self._note(f"{where}: zero {unit} is not zero in SI; give another unit, such as K.")
            unit = ""
        number = self._read.number(value, unit, where)
        if (si := si_unit(unit)) != unit:
            number, unit = float(converted(number, unit, si)), si
        declared = ParameterDeclaration(name, number, unit, sign)
        self._put("parameter", self.parameters, name, declared)
        return symbol

    def table(
        self, name: str, x: Any, y: Any, periodic: bool = False,
        units: tuple[str, str] = ("", ""), kind: Kind = "pchip", beyond: Beyond = "stop",
        ends: Ends = "not-a-knot", period: Any = None,
    ) -> TableFunction:  # fmt: skip
        """A function through points, of a coordinate, a length, a velocity, a parameter or t.

        A call, ``pressure(crank.phi)`` or ``law(t)``, may stand in forces, potentials, motion laws,
        profiles and constraints, with exact derivatives. Steps end where a derivative of the table
        jumps. A run ends where it leaves the table, and the message names the table.

        Parameters
        ----------
        x, y
            The points, x strictly ascending: numbers in `units`, or quantities. Two at least,
            three for ``"akima"``, four for ``"spline"``; of a periodic table one more.
        periodic
            Whether the function is periodic; then the last point repeats the first, a period later.
            The period of a function of an angle is a whole number of turns, or a turn divided by a
            whole number.
        units
            Units of the numbers of x and y, which are converted to SI. If the units of the table's
            argument and of its place in a law are known (quantities, coordinates, velocities, t),
            they must be these.
        kind
            ``"pchip"``, for data: monotone where the data are, no overshoot, a continuous slope.
            ``"linear"``: straight from point to point. ``"akima"``: rounder than pchip, with little
            overshoot. ``"spline"``, for smooth functions: continuous second derivatives, which
            constraints on coordinates and profiles need; it oscillates where data have a corner.
        beyond
            Beyond the ends of a table that is not periodic, ``"stop"`` ends the run, ``"hold"``
            keeps the value of the end, and ``"extrapolate"`` continues the last piece.
        ends
            For a spline that is not periodic: ``"not-a-knot"``, or ``"natural"``, with the second
            derivative zero at both ends.
        period
            For a periodic function, in the unit of x: if the points end before ``x[0] + period``,
            the row with the first value is added there.
        """
        where = f"table '{name}'"
        if not are_units(units):
            self._note(f"{where}: units={shown(units)}; give the units of x and y: ('s', 'm').")
            units = ("", "")
        before = len(self.problems)
        periodic = self._read.flag(periodic, f"{where}: periodic")
        kind = self._read.choice(kind, KINDS, f"{where}: kind")
        beyond = self._read.choice(beyond, BEYOND, f"{where}: beyond")
        ends = self._read.choice(ends, ENDS, f"{where}: ends")
        repeats = periodic or period is not None
        fewest = FEWEST[kind] + (repeats and kind != "spline") - (period is not None)
        given_units, units = units, (si_unit(units[0]), si_unit(units[1]))
        at, values = (
            [*map(float, converted(self._read.numbers(given, unit, where, axis, fewest), unit, si))]
            for given, unit, si, axis in zip((x, y), given_units, units, "xy", strict=True)
        )
        if period is not None:
            length = self._read.finite(period, given_units[0], f"{where}: period")
            length = float(converted(length, given_units[0], units[0]))
        if len(self.problems) == before:
            unused = _unused(repeats, kind, beyond, ends)
            try:
                if period is not None and len(at) == len(values) > 0:
                    at, values = with_closing_row(at, values, length)
                problems = [*point_problems(at, values, repeats, kind), *unused]
            except ValueError as misfits:
                problems = [str(misfits)]
            over_angle = misfit(at, period is not None) if repeats and not problems else ""
            if units[0] == "rad" and over_angle:
                problems.append(over_angle)
            for problem in problems:
                self._note(f"{where}: {problem}")
        if self._claim("table", name) and len(self.problems) == before:
            table = fit(name, at, values, repeats, kind, ends, beyond)
            if all(math.isfinite(c) for row in table.rows for c in row):
                _warn_of_excess(table, min(values), max(values))
                return TableFunction(table, units, over_angle)
            self._note(f"{where}: no finite curve goes through points so far apart; rescale them.")
        return TableFunction(fit("none", (0.0, 1.0, 2.0, 3.0), (0.0,) * 4, periodic=False))

    def depends_on(self, path: str | Path) -> Path:
        """Name a data file that the declaration reads: a change of the file makes builds stale."""
        try:
            file = Path(path).resolve()
            found = file.is_file()
        except (TypeError, ValueError, OSError) as error:
            reason = f"is no path of a file ({one_line(error)})"
            self._note(f"depends_on({shown(path)}): {shown(path)} {reason}.")
            return Path()
        if found:
            self.files += (file,)
        else:
            self._note(f"depends_on({shown(path)}): there is no file {one_line(file)}.")
        return file

    def state(
        self, name: str, rate: Any = None, start: Any = 0, unit: str = "", nominal: Any = 1
    ) -> Velocity:
        """A state of first order, ẏ = rate: the current of a motor, a filter, a pressure.

        It returns the symbol of y. The symbol may be used like a velocity: in forces, torques,
        conditions and rates of other states, but not in laws of motion and potentials. A scene for
        dynamics contains a state if one of its effects does, or if it names the state among its
        effects.

        Parameters
        ----------
        rate
            ẏ, an expression in `unit` per second of t, q, q̇, states and parameters; or a function
            of y that returns one, ``lambda i: (u - R*i) / L``; or None if `state_equation` gives
            the rate later, for states whose rates contain one another.
        start
            y at the start of a run, in `unit`, unless the scene or the run says otherwise.
        unit
            SI unit of y, such as ``"A"`` or ``"Pa"``; empty for a pure number.
        nominal
            Typical size of y, in `unit`: absolute tolerances are relative to it.
        """
        where = f"state '{name}'"
        declared = self._declare_state(name, where, start, unit, nominal)
        if rate is not None:
            self._set_rate(declared, rate, where)
        return declared.symbol

    def state_equation(self, state: Velocity, rate: Any) -> None:
        """Give ẏ of a state that was declared without a rate.

        Parameters
        ----------
        state
            The symbol that `state` returned.
        rate
            As in `state`.
        """
        known = {s.symbol: s for s in self.states.values()}
        symbol: object = state
        found = known.get(symbol) if isinstance(symbol, Velocity) else None
        if found is None or found.clock is not None or found.triggers:
            self._note(f"state_equation({shown(state)}, ...): give what model.state(...) returned.")
        elif found.given:
            self._note(f"state '{found.name}' has two rates; give one.")
        else:
            self._set_rate(found, rate, f"state '{found.name}'")

    def sampled(
        self, name: str, every: Any = None, value: Any = None, delay: Any = 0, start: Any = 0,
        unit: str = "", nominal: Any = 1, when: Any = None,
    ) -> Velocity:  # fmt: skip
        """A value that a clock or an event renews; between renewals it is constant.

        It returns the symbol of the value, as `state` does. The expression is evaluated at t = 0,
        `every`, 2 `every` …. Values that are renewed at one instant are evaluated in the order of
        their declaration; each sees the new values of those before it. Steps end at samples.

        Parameters
        ----------
        every
            The period of the clock, s.
        when
            In place of a clock: a condition; the value is renewed each time it begins to hold.
        value
            An expression of t, q, q̇, states and parameters in `unit`; or a function of the value
            itself that returns one, ``lambda e: e + k*error``; or None if you give a function to
            the run, ``simulate(controllers={name: ...})``.
        delay
            Time from a clock's sample until it acts, s.
        start
            The value before the first sample acts, in `unit`.
        unit, nominal
            As in `state`.
        """
        where = f"sampled value '{name}'"
        if (every is None) == (when is None):
            self._note(f"{where}: give every=, the period of its clock, or when=, a condition.")
        if when is not None:
            if value is None:
                self._note(f"{where}: when= without value=; give what it becomes there.")
            if delay != 0 and self._value(delay, "s", f"delay of {where}") != 0:
                self._note(f"{where}: delay= is of a clock; leave it out, or give every=.")
            indicator = self._read.gated(sympy.S.One, "", where, when)
            declared = self._declare_state(name, where, start, unit, nominal)
            sample = self._expression(ZERO if value is None else value, declared, unit, where)
            return self._complete(declared, triggers=(Trigger(indicator, sample),))
        period = self._value(every, "s", f"period of {where}", "positive")
        wait = self._value(delay, "s", f"delay of {where}", "nonnegative")
        self._note_violated(where, *sign_conditions(("period", period, "s"), positive=True))
        self._note_violated(where, *sign_conditions(("delay", wait, "s")))
        declared = self._declare_state(name, where, start, unit, nominal)
        sample = self._expression(value, declared, unit, where)
        return self._complete(declared, clock=Clock(period, wait), sample=sample)

    def latch(self, name: str, when: Any, reset: Any = None) -> sympy.Basic:
        """A condition with a memory: it holds once `when` has held, until `reset` begins to hold.

        It returns the condition, which may be used in ``when=`` of forces, in other conditions and
        in a Piecewise. Its value, 1 or 0, is a state of the same name.

        Parameters
        ----------
        when, reset
            Conditions of t, q, q̇, states and parameters; without `reset` the latch never ends.
        """
        where = f"latch '{name}'"
        both = [(when, sympy.S.One)] + ([] if reset is None else [(reset, ZERO)])
        if when is None:
            self._note(f"{where}: when=None is no condition; compare coordinates, velocities or t.")
            both = []
        triggers = tuple(
            Trigger(self._read.gated(sympy.S.One, "", where, condition), value)
            for condition, value in both
        )
        declared = self._declare_state(name, where, 0, "", 1)
        return self._complete(declared, triggers=triggers) > sympy.Rational(1, 2)

    def _complete(self, declared: State, **how: Any) -> Velocity:
        """Say how a declared state changes; its symbol."""
        if declared.name in self.states:
            self.states[declared.name] = replace(declared, given=True, **how)
        return declared.symbol

    def _declare_state(self, name: str, where: str, start: Any, unit: str, nominal: Any) -> State:
        known = unit
        if not known_unit(unit) or si_factor(unit) != 1.0:
            self._note(f"{where}: the unit {shown(unit)} is no SI unit; use SI names, 'A', 'N/m'.")
            known = ""
        first, size = (
            self._read.finite(given, known, f"{word} of {where}")
            for given, word in ((start, "start"), (nominal, "nominal"))
        )
        if not size > 0.0:
            self._note(f"nominal of {where} is {size:g}; give a positive size, in {known or '1'}.")
            size = 1.0
        declared = State(name, known, first, size)
        self._put("state", self.states, name, declared)
        return declared

    def _set_rate(self, declared: State, rate: Any, where: str) -> None:
        unit = f"{declared.unit or '1'}/s"
        self._complete(declared, rate=self._expression(rate, declared, unit, f"rate of {where}"))

    def _expression(self, value: Any, declared: State, unit: str, where: str) -> Any:
        """An expression, or the value that a function of the state returns."""
        if value is None:
            return None
        if callable(value) and not isinstance(value, sympy.Basic):
            return self._read.result_of(value, (declared.symbol,), unit, where)
        return self._value(value, unit, where)

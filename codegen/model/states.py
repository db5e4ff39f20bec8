"""The states of a declaration besides those of its bodies: first-order states, sampled values."""

from dataclasses import replace
from typing import Any

import sympy

from codegen.declare.element_conditions import sign_conditions
from codegen.declare.state import Clock, State, Trigger
from codegen.declare.symbols import Velocity
from codegen.model.base import Declarations
from codegen.readers.quantities import is_si_unit
from codegen.readers.values import shown

ZERO = sympy.S.Zero


class States(Declarations):
    """First-order states and sampled values of a declaration."""

    def state(
        self, name: str, rate: Any = None, start: Any = 0, unit: str = "", nominal: Any = 1
    ) -> Velocity:
        """A state of first order, ẏ = rate: the current of a motor, a filter, a pressure.

        It answers the symbol of y, which may stand wherever a velocity may: in forces, torques,
        conditions and rates of other states, and in no law of motion and no potential. A state
        takes part in the scenes for dynamics in which something that acts contains it, or which
        name it among their effects.

        Parameters
        ----------
        rate
            ẏ, an expression in `unit` per second of t, q, q̇, states and parameters; or a function
            of y that answers one, ``lambda i: (u - R*i) / L``; or None where `state_equation`
            gives it later, as states need that contain one another.
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
        """Give ẏ of a state that was declared without.

        Parameters
        ----------
        state
            What `state` answered.
        rate
            As in `state`.
        """
        known = {s.symbol: s for s in self.states.values()}
        symbol: object = state
        found = known.get(symbol) if isinstance(symbol, Velocity) else None
        if found is None or found.clock is not None or found.triggers:
            self._note(f"state_equation({shown(state)}, ...): give what model.state(...) answered.")
        elif found.given:
            self._note(f"state '{found.name}' has two rates; give one.")
        else:
            self._set_rate(found, rate, f"state '{found.name}'")

    def sampled(
        self, name: str, every: Any = None, value: Any = None, delay: Any = 0, start: Any = 0,
        unit: str = "", nominal: Any = 1, when: Any = None,
    ) -> Velocity:  # fmt: skip
        """A value that a clock or an event renews, and that is kept in between.

        It answers the symbol of the value, as `state` does. At t = 0, `every`, 2 `every` … the
        expression is evaluated; values that are renewed at one instant are so in the order of
        their declaration, each from those that were renewed before it. Steps end at samples.

        Parameters
        ----------
        every
            The period of the clock, s.
        when
            In place of a clock: a condition; the value is renewed each time it begins to hold.
        value
            An expression of t, q, q̇, states and parameters in `unit`; or a function of the value
            itself that answers one, ``lambda e: e + k*error``; None where a run brings a function
            of its own, ``simulate(controllers={name: ...})``.
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
        """A condition with a memory: once `when` has held, it holds, until `reset` begins to hold.

        It answers the condition, which may stand in ``when=`` of forces, in other conditions and in
        a Piecewise. Its value, 1 or 0, is a state of the name.

        Parameters
        ----------
        when, reset
            Conditions of t, q, q̇, states and parameters; without `reset` it holds for good.
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
        if not is_si_unit(unit):
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
        if self._claim("state", name):
            self.states[declared.name] = declared
        return declared

    def _set_rate(self, declared: State, rate: Any, where: str) -> None:
        unit = f"{declared.unit or '1'}/s"
        self._complete(declared, rate=self._expression(rate, declared, unit, f"rate of {where}"))

    def _expression(self, value: Any, declared: State, unit: str, where: str) -> Any:
        """An expression, or what a function of the state answers."""
        if value is None:
            return None
        if callable(value) and not isinstance(value, sympy.Basic):
            return self._read.result_of(value, (declared.symbol,), unit, where)
        return self._value(value, unit, where)

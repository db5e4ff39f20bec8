"""The numbers of a declaration: parameters, tables, and the files that they come from."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args
from warnings import warn

from codegen.declare.symbols import Parameter, ParameterDeclaration, SignRule
from codegen.errors import TableWarning
from codegen.model.base import Declarations
from codegen.readers.quantities import is_si_unit, known_unit, si_factor
from codegen.readers.values import one_line, shown
from codegen.tables.piecewise_cubic import Beyond, Ends, Kind, Table, excess, fit
from codegen.tables.table_function import FEWEST, TableFunction, point_problems

_EXCESS = 0.05  # safety: of the range of the data; a curve that leaves it by more swings

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
    """Whether they are two SI units."""
    return isinstance(units, tuple | list) and len(units) == 2 and all(map(is_si_unit, units))


class Values(Declarations):
    """The parameters, tables and data files of a declaration."""

    def parameter(self, name: str, value: Any, unit: str = "", sign: SignRule = "") -> Parameter:
        """A number that runs may change without a new build.

        Parameters
        ----------
        value
            The default: a number in `unit`, or a pint quantity that converts to it.
        unit
            A label in SI units such as ``"kg m^2"``; empty for a pure number. Values given at run
            time are in it.
        sign
            A rule that every value must obey; masses and inertias are positive by themselves.
        """
        symbol = Parameter(str(name), real=True)
        where = f"parameter '{name}'"
        if type(unit).__name__ == "Unit" and type(unit).__module__.startswith("pint"):
            unit = str(unit)
        label: object = unit
        unit = " ".join(label.split()) if isinstance(label, str) else unit
        sign = self._read.choice(sign, ("", "positive", "nonnegative"), f"{where}, sign")
        if not known_unit(unit):
            what = shown(unit)
            self._note(f"{where}: the unit {what} is not known; use SI names, 'kg m^2'.")
            unit = ""
        elif (factor := si_factor(unit)) != 1.0:
            self._note(
                f"{where}: {unit!r} is no SI unit (one of it is {factor:g} in SI); label the "
                f"parameter with the SI unit, and give the value as a quantity in {unit}."
            )
            unit = ""
        number = self._read.number(value, unit, where)
        if self._claim("parameter", name):
            self.parameters[name] = ParameterDeclaration(name, number, unit, sign)
        return symbol

    def table(
        self, name: str, x: Any, y: Any, periodic: bool = False,
        units: tuple[str, str] = ("", ""), kind: Kind = "pchip", beyond: Beyond = "stop",
        ends: Ends = "not-a-knot",
    ) -> TableFunction:  # fmt: skip
        """A function through points, of a coordinate, a length, a velocity, a parameter or t.

        Called with an expression, ``pressure(crank.phi)`` or ``law(t)``, it may stand in forces,
        potentials, motion laws, profiles and constraints, with exact derivatives. Steps of a run
        end where a derivative of it jumps, and the switch of its ends stops the run by name.

        Parameters
        ----------
        x, y
            The points, x strictly ascending: numbers in `units`, or pint quantities. Two at least,
            three for ``"akima"``, four for ``"spline"``; of a periodic table one more.
        periodic
            Whether the function repeats; the last point is the first one, a period later.
        units
            SI units of x and y. What the table is called with, and what it stands for, is compared
            with them where its unit is known: quantities, coordinates, velocities, t.
        kind
            ``"pchip"``, for data: as monotone as these, no overshoot, a continuous slope.
            ``"linear"``: straight from point to point. ``"akima"``: rounder than pchip, with little
            overshoot. ``"spline"``, for smooth functions: continuous second derivatives, which
            constraints on coordinates and profiles need; between data with edges it swings.
        beyond
            What a table that does not repeat is beyond its ends: ``"stop"`` ends the run there,
            ``"hold"`` keeps the value of the end, ``"extrapolate"`` goes on with the end's piece.
        ends
            Of a spline that does not repeat: ``"not-a-knot"``, or ``"natural"``, with the second
            derivative zero at both ends.
        """
        where = f"table '{name}'"
        if not are_units(units):
            self._note(f"{where}: units={shown(units)}; give the SI units of x and y: ('s', 'm').")
            units = ("", "")
        before = len(self.problems)
        periodic = self._read.flag(periodic, f"{where}: periodic")
        kind = self._read.choice(kind, KINDS, f"{where}: kind")
        beyond = self._read.choice(beyond, BEYOND, f"{where}: beyond")
        ends = self._read.choice(ends, ENDS, f"{where}: ends")
        fewest = FEWEST[kind] + (periodic and kind != "spline")
        at, values = (
            self._read.numbers(given, unit, where, axis, fewest)
            for given, unit, axis in ((x, units[0], "x"), (y, units[1], "y"))
        )
        if len(self.problems) == before:
            unused = _unused(periodic, kind, beyond, ends)
            for problem in (*point_problems(at, values, periodic, kind), *unused):
                self._note(f"{where}: {problem}")
        if self._claim("table", name) and len(self.problems) == before:
            table = fit(name, at, values, periodic, kind, ends, beyond)
            if all(math.isfinite(c) for row in table.rows for c in row):
                _warn_of_excess(table, min(values), max(values))
                return TableFunction(table, units)
            self._note(f"{where}: no finite curve goes through points so far apart; rescale them.")
        return TableFunction(fit("none", (0.0, 1.0, 2.0, 3.0), (0.0,) * 4, periodic=False))

    def depends_on(self, path: str | Path) -> Path:
        """Name a data file that the declaration reads: a change of it makes builds stale."""
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

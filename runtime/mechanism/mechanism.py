"""The data of a mechanism in one scene, which all analyses take: tables, kernels, origin."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError
from runtime.core.kernel_abi import Kernels
from runtime.core.system import System
from runtime.mechanism.companion_modules import (
    Kind,
    Origin,
    has_companion,
    load_companion,
)
from runtime.mechanism.module_tables import Description
from runtime.mechanism.reduced_kernels import Reduced, gather_reduced
from runtime.mechanism.system import Tangents, common_system, gather_tangents

Values = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A mechanism in one scene."""

    description: Description  # the tables of the generated module
    kernels: Kernels  # its compiled functions, callable from any numba code
    path: Path  # the generated module's file
    origin: Origin | None = None  # from which companion modules are built
    # constraints that imply the others; None: all are independent
    sufficient: tuple[int, ...] | None = None

    @property
    def title(self) -> str:
        """`model/scene`, as messages name it."""
        return self.description.title

    @property
    def independent(self) -> tuple[int, ...]:
        """Indices of independent constraints: none of them follows from the others."""
        every = tuple(range(len(self.description.constraints)))
        return every if self.sufficient is None else self.sufficient

    @cached_property
    def siblings(self) -> dict[str, "Mechanism"]:
        """Scene → the mechanism of it, of those in which a run goes on with other joints."""
        return {self.description.scene: self}

    @cached_property
    def kernel_table(self) -> npt.NDArray[np.int64]:
        """Addresses of the kernels, for compiled loops of the runtime."""
        return self.kernels.table()

    @cached_property
    def shape(self) -> dict[str, npt.NDArray[Any]]:
        """What the tables say of coordinates and constraints: arrays of a `start_table`."""
        description = self.description
        lengths, neutral = description.is_length, np.array(description.neutral, np.float64)
        scaled, typical = lengths.copy(), np.ones(len(lengths))
        for state in description.states:
            scaled[state.column], typical[state.column] = False, state.nominal
        angles = np.flatnonzero(~lengths)
        turns = np.zeros((2, len(lengths)))  # every angle by another amount
        turns[0, angles] = 0.5 + 0.2 * np.sin(1.0 + angles)
        turns[1, angles] = -(0.5 + 0.2 * np.cos(2.0 * angles))
        integers = {
            "slope_rows": description.jacobian_rows,
            "slope_columns": description.jacobian_columns,
            "of_length": lengths,
            "scaled_by_length": scaled,
            "every": np.ones(len(lengths)),
            "in_metres": [row.unit == "m" for row in description.parameters],
        }
        found = {name: np.array(values, np.int64) for name, values in integers.items()}
        return {**found, "typical": typical, "turns": turns, "neutral": neutral}

    @cached_property
    def system(self) -> System:
        """The equations in all coordinates, as the integrator takes them."""
        description, kernels = self.description, self.kernels
        rows, columns = description.jacobian_rows, description.jacobian_columns
        n, m = len(description.coordinates), len(description.constraints)
        parameters = len(description.parameters)
        shares = parameters + len(description.stiction)
        return replace(
            common_system(description, kernels, rows, columns, n, m),
            reaction_rows=len(description.reactions),
            power_rows=len(description.powers),
            balanced_rows=description.balanced_rows,
            powers_of_multipliers=_depend_on_multipliers(description, kernels),
            limits=description.friction_limits,
            stiction=tuple((k, parameters + i) for i, k in enumerate(description.stiction)),
            shares=tuple((k, shares + i) for i, k in enumerate(description.shares)),
            superposes=description.superposes,
            linear_reactions=description.has_linear_reactions,
            independent=self.independent,
        )

    @cached_property
    def tangents(self) -> Tangents:
        """Exact derivatives of the kernels; their file is built where it is missing."""
        if not self.description.has_masses:
            raise AnalysisError(
                f"{self.title} is kinematic: no masses move in it, so there are no accelerations "
                "under forces to differentiate. Load a scene with masses."
            )
        return gather_tangents(self._tangents_module)

    @cached_property
    def _tangents_module(self) -> ModuleType:
        return load_companion(self.origin, "tangents", self.title, self.path)

    def for_tangents(self, p: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """``p`` with the workspace that the derivatives need, which may be larger."""
        own, needed = self.description.workspace, getattr(self._tangents_module, "WORKSPACE", 0)
        return np.append(p, np.zeros(needed - own)) if needed > own else p

    @cached_property
    def reduced(self) -> Reduced:
        """The equations in reduced coordinates; their file is built where it is missing."""
        module = load_companion(self.origin, "reduced", self.title, self.path)
        return gather_reduced(module, self.description)

    def has_companion(self, kind: Kind) -> bool:
        """Whether a companion of the generated module, "tangents" or "reduced", is built."""
        return kind in self.__dict__ or has_companion(self.origin, kind)


def _depend_on_multipliers(description: Description, kernels: Kernels) -> bool:
    """Whether a power follows from a reaction: of a driver, of a friction that slides.

    That of a driver does, whatever it is at an instant that is tried; of the others it shows by a
    multiplier that is not a number, also where the other factor is zero.
    """
    n, m, table = len(description.coordinates), len(description.constraints), description.parameters
    if not (m and description.powers):
        return False
    sources = {row.name for row in description.powers}
    if any(row.element in sources for row in description.constraints):
        return True
    p = np.zeros(description.parameter_slots)
    p[: len(table)] = [row.default for row in table]
    kernels.constants(p)
    q, v = np.full(n, 0.7), np.linspace(1.0, 2.0, n)
    without, given = np.zeros((2, len(description.powers)))
    for mode in (0, 1):
        modes = np.full(len(description.switches), mode)
        kernels.powers(0.3, q, v, p, modes, np.zeros(m), without)
        kernels.powers(0.3, q, v, p, modes, np.full(m, np.nan), given)
        if np.any(np.isnan(given) & ~np.isnan(without)):
            return True
    return False

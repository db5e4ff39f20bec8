"""The data of a mechanism in one scene, which all analyses take: tables, kernels, origin.

Exact derivatives, reduced equations, the picture and all outputs are generated into files of their
own next to the scene's, its companions. One belongs to one text of that file, whose SHA-256 it
names: with any other the slots of ``p`` might differ, and it is built again.

When joints come or go, the run goes on in another scene, whose module is found beside this scene's
or built.
"""

import pickle
from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from codegen.errors import AnalysisError, SupersededError
from codegen.files.build_records import fresh_text, records, unchanged
from codegen.files.generated_modules import companion_path, import_generated, scene_path, unroll_of
from runtime.core.kernel_abi import Kernels, gather
from runtime.core.system import System
from runtime.mechanism.module_tables import Description, describe
from runtime.mechanism.origin import CONTENTS, Kind, Origin
from runtime.mechanism.system import Reduced, Tangents, common_system, gather_tangents

if TYPE_CHECKING:
    from codegen import Model, Scene
    from codegen.generated_files.generated_file import SceneReport

Numbers = Mapping[str, float]
Values = Mapping[str, float | str]  # numbers in SI, and texts such as "45 mm"

_ARRIVALS = 32  # layout: machines of other processes that are kept loaded


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A mechanism in one scene."""

    description: Description  # the tables of the generated module
    kernels: Kernels  # its compiled functions, callable from any numba code
    path: Path  # the generated module's file
    origin: Origin | None = None  # from which companion modules are built
    # the machine with all constraints, of one that has independent rows in the place of some
    whole: "Mechanism | None" = None

    def __reduce__(self) -> tuple[Any, ...]:
        """As what it was loaded from: compiled code and its addresses hold in one process."""
        if self.whole is not None:
            return getattr, (self.whole, "with_independent_rows")
        origin = self.need_origin("a machine in another process").portable()
        state = {"description": self.description, "path": self.path, "origin": origin}
        if "siblings" in vars(self):
            state["siblings"] = self.siblings
        return _arrived, (self.path, origin.digest), state

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update({**state, **vars(self)})

    def __getattr__(self, name: str) -> Any:
        """The kernels of a machine that was pickled, loaded when they are first needed."""
        if name != "kernels" or self.origin is None:
            raise AttributeError(name)
        module = import_generated(self.origin.path, self.origin.text)
        return vars(self).setdefault("kernels", gather(module))

    @property
    def title(self) -> str:
        """`model/scene`, as messages name it."""
        return self.description.title

    @property
    def independent(self) -> tuple[int, ...]:
        """Indices of independent constraints: none of them follows from the others."""
        every, redundant = range(len(self.description.constraints)), self.description.redundant
        return tuple(k for k in every if k not in redundant)

    @cached_property
    def with_independent_rows(self) -> "Mechanism":
        """The same with independent rows in the place of constraints that follow from others."""
        kernels, description = self.kernels, self.description
        names = "constraints", "jacobian", "velocity_rhs", "acceleration_rhs"
        chosen = {name: getattr(kernels, f"independent_{name}") for name in names}
        tables = replace(
            description,
            jacobian_rows=description.independent_jacobian_rows,
            jacobian_columns=description.independent_jacobian_columns,
        )
        return replace(self, kernels=replace(kernels, **chosen), description=tables, whole=self)

    @cached_property
    def siblings(self) -> dict[str, "Mechanism"]:
        """Scene → the mechanism of it, of those in which a run goes on with other joints."""
        return {self.description.scene: self}

    @cached_property
    def starts(self) -> dict[str, Any]:
        """What was given for a run, as a text → the coordinates of its start, kept to be copied."""
        return {}

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
        rows = {row.name: k for k, row in enumerate(description.constraints, 1)}
        turns = np.zeros((2, len(lengths)))  # every angle by another amount
        turns[0, angles] = 0.5 + 0.2 * np.sin(1.0 + angles)
        turns[1, angles] = -(0.5 + 0.2 * np.cos(2.0 * angles))
        integers = {
            "slope_rows": description.jacobian_rows,
            "slope_columns": description.jacobian_columns,
            "of_length": lengths,
            "scaled_by_length": scaled,
            "every": np.ones(len(lengths)),
            "counted": [row.is_counted * rows.get(row.name, 0) for row in description.coordinates],
            "in_metres": [row.unit == "m" for row in description.parameters],
            "turning": [first for _, first in description.turning],
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
        behind = parameters + len(description.stiction)
        return replace(
            common_system(description, kernels, rows, columns, n, m, behind),
            reaction_rows=len(description.reactions),
            power_rows=len(description.powers),
            balanced_rows=description.balanced_rows,
            powers_of_multipliers=_depend_on_multipliers(description, kernels),
            limits=description.friction_limits,
            stiction=tuple((k, parameters + i) for i, k in enumerate(description.stiction)),
            linear_reactions=not any(row.kind == "friction" for row in description.effects),
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
        return gather_tangents(self.companion("tangents"))

    @cached_property
    def reduced(self) -> Reduced:
        """The equations in reduced coordinates; their file is built where it is missing."""
        return Reduced(self.companion("reduced"), self.description)

    @cached_property
    def with_all_outputs(self) -> "Mechanism":
        """The same with every output that follows from states; its file is built where missing."""
        module = self.companion("outputs")
        return Mechanism(describe(module), gather(module), self.path)

    def has_companion(self, kind: Kind) -> bool:
        """Whether a companion of the generated module is built."""
        origin = self.origin
        return kind in self.__dict__ or (
            origin is not None and origin.current_companion(kind) is not None
        )

    def need_origin(self, what: str) -> Origin:
        """The source of the machine; AnalysisError where it has none: `what` cannot be built."""
        if self.origin is None:
            raise AnalysisError(
                f"{self.title} was put together without its model, from {self.path}, so {what} "
                "cannot be built. Load it by linkwright.load."
            )
        return self.origin

    def declared(self, what: str) -> "tuple[Path | Model, str | Scene]":
        """Model and scene, from which `what` is built; AnalysisError where none is known here."""
        origin = self.need_origin(what)
        if not isinstance(origin.model, bytes):
            return origin.model, origin.scene
        model, scene = pickle.loads(origin.model)
        if model is None:
            raise AnalysisError(
                f"{self.title} is of a model in another process that could not be pickled, so "
                f"{what} cannot be built here. Build it there before, or load a model file."
            )
        return model, scene

    def companion(self, kind: Kind) -> ModuleType:
        """The module that belongs to the scene's; built if missing or stale.

        Raises AnalysisError if the machine was not loaded from a model, GeneratedFileError if the
        file was edited by hand, or cannot be written, SupersededError if the model has changed.
        """
        origin = self.need_origin(f"its {CONTENTS[kind]}")
        text = origin.current_companion(kind)
        if text is not None:
            return import_generated(companion_path(origin.path, kind), text)
        _, scene = self.declared(f"its {CONTENTS[kind]}")
        (report,) = self.rebuilt(f"its {CONTENTS[kind]}", scene, **{kind: True})
        companion = getattr(report, kind)
        return import_generated(companion.path, companion.text)

    def rebuilt(self, what: str, *scenes: "str | Scene", **kinds: Any) -> "tuple[SceneReport, ...]":
        """New builds of scenes of its model; SupersededError if its own has another text now."""
        from codegen import build

        origin, (model, _) = self.need_origin(what), self.declared(what)
        folder = origin.path.parent
        reports = build(model, scenes, folder, compile=False, **{"unroll": None, **kinds}).scenes
        for now in (one.digest for one in reports if one.path == origin.path):
            if now != origin.digest:
                unseen = "; ".join(x for record in records(origin.path) for x in record.unwatched)
                why = (
                    f"its numbers may differ at each reading ({unseen}). Give its random numbers a "
                    "seed, or make parameters of what differs."
                    if unseen else
                    "the model, or the generator, has changed since the machine of scene "
                    f"'{self.description.scene}' was loaded. Load the machine again."
                )  # fmt: skip
                raise SupersededError(
                    f"{origin.path} is {origin.digest[:12]}... in this machine and {now[:12]}... "
                    f"now, so that {what} would be that of another one: {why}"
                )
        return reports


def read_mechanism(
    path: Path, text: str, model: "Path | Model", scene: "str | Scene | None" = None
) -> Mechanism:
    """The mechanism of a generated file, which has this text."""
    module = import_generated(path, text)
    description = describe(module)
    origin = Origin(model, scene or description.scene, path, text)
    return Mechanism(description, gather(module), path, origin)


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


def sibling(mechanism: Mechanism, joints: Iterable[str]) -> Mechanism:
    """The mechanism in which a run goes on where these joints come or go at one instant.

    Raises ModelError where it is to be built and its joints and drivers permit no motion.
    """
    changed, known = frozenset(joints), mechanism.siblings
    followers = mechanism.description.followers.items()
    scene = next(scene for scene, change in followers if change == changed)
    if scene not in known:
        known[scene] = found = _built(mechanism, scene, changed)
        found.__dict__["siblings"] = known  # which all of them share
    return known[scene]


def sibling_named(mechanism: Mechanism, scene: str) -> Mechanism | None:
    """The mechanism, or one into which it may turn as joints come and go, by its scene's name."""
    if scene == mechanism.description.scene:
        return mechanism
    joints = mechanism.description.followers.get(scene)
    return None if joints is None else sibling(mechanism, joints)


def seeking(mechanism: Mechanism, unknown: tuple[str, ...]) -> Mechanism:
    """The mechanism of the same scene in which the values of these effects are sought; built."""
    known: dict[tuple[str, ...], Mechanism] = vars(mechanism).setdefault("seeking", {})
    if unknown not in known:
        from codegen.reading.scene_selection import declared, scene_seeking

        what = f"its variant with the unknown {', '.join(unknown)}"
        origin, source = mechanism.need_origin(what), mechanism.declared(what)
        variant = scene_seeking(*declared(*source), unknown)
        reports = mechanism.rebuilt(what, source[1], variant, unroll=unroll_of(origin.text))
        report = next(one for one in reports if one.path != origin.path)
        known[unknown] = read_mechanism(report.path, report.text, source[0], variant)
    return known[unknown]


def _built(mechanism: Mechanism, scene: str, joints: Set[str]) -> Mechanism:
    """The sibling's module, loaded where it is there and of the same sources, else built."""
    what = f"scene '{scene}', in which the run goes on,"
    origin = mechanism.need_origin(what)
    own = origin.path.stem.partition("__")[0]
    file = origin.model if isinstance(origin.model, Path) else None
    known = unchanged(origin.path, origin.text, file) if file else None
    if file and known and isinstance(origin.scene, str):
        place = scene_path(origin.path.parent, own, scene)
        if text := fresh_text(place, file, scene):
            return read_mechanism(place, text, file, scene)
    model, declared = mechanism.declared(what)
    wanted: str | Scene = scene
    if not isinstance(declared, str):
        assert declared.owner is not None
        after = {*declared.connected} ^ joints
        wanted = declared.owner.reconnected(declared, tuple(after))
    is_sure = file is None or (known is not None and not known.unwatched)
    reports = mechanism.rebuilt(
        what, *([] if is_sure else [declared]), wanted, unroll=unroll_of(origin.text)
    )
    report = next(one for one in reports if is_sure or one.path != origin.path)
    return read_mechanism(report.path, report.text, model, wanted)


@lru_cache(maxsize=_ARRIVALS)
def _arrived(path: Path, digest: str) -> Mechanism:
    """The mechanism of a text that was pickled, without its state: once for all of its arrivals."""
    return Mechanism.__new__(Mechanism)

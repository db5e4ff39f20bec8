"""The ledger: the parts of a machine that a scene contains, why, and the cost of each."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path

from codegen.declare.element import Constraint, Effect
from codegen.declare.returned_values import friction_law, replaced_body
from codegen.declare.scene import Scene
from codegen.derive.equations import parts_of
from codegen.driver import translate
from codegen.emit.kernel import Arguments
from codegen.emit.module import LONGEST, kernel_texts, statements
from codegen.emit.rolled_kernel import RolledKernelText
from codegen.errors import InputError
from codegen.explain import operations_by_part as costs
from codegen.generated_files.generated_file import Clock
from codegen.lower.lowered_scene import Lowered
from codegen.model import Model
from codegen.model.base import TRACKED
from codegen.model.bodies import FORMS
from codegen.model.scene_requests import ALL, DEFAULT, GROUPS, NONE, OF_ANALYSIS
from codegen.reading.model_file import read_model
from codegen.reading.scene_selection import valid_scenes

SHARED = {costs.SOLUTION: "solution of M q̈ + Φ_qᵀ λ = Q", "correction": "recovery of q and q̇"}
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Part:
    """An element of the declaration, a fidelity of one, or work that all elements share."""

    name: str
    kind: str
    role: str  # "joint", "driver", "effect", "fidelity" or "shared"
    acts: bool  # whether it is in
    why: str  # the reason
    operations: dict[str, int] = field(default_factory=dict)  # kernel → incremental cost
    own: dict[str, int] = field(default_factory=dict)  # of an effect: kernel → marginal cost
    # Measured time that it adds to an evaluation of `accelerations`; None without a measurement.
    nanoseconds: float | None = None
    events: tuple[str, ...] = ()  # the conditions whose switching functions it brings
    # Of a run, None without one: its events, its share of the steps repeated for events (in
    # proportion to the events), and the seconds that `accelerations` spent on it.
    run_events: int | None = None
    run_retakes: float | None = None
    run_seconds: float | None = None

    @property
    def solving(self) -> int:
        """Its operations in the kernel `accelerations`."""
        return self.operations.get("accelerations", 0)

    @property
    def total(self) -> int:
        """Its operations in all kernels."""
        return sum(self.operations.values())


@dataclass(frozen=True)
class OutputEntry:
    """A word of ``outputs=``, whether the scene has it, and why."""

    name: str
    asked: bool
    why: str


@dataclass(frozen=True)
class RunCosts:
    """Costs of a run with the scene's defaults."""

    t_end: float
    evaluations: int  # of `accelerations`
    steps: int  # accepted
    rejected: int  # for their error
    retakes: int  # steps repeated for the location of events
    events: int
    seconds: float  # wall time of the integration


@dataclass(frozen=True)
class Ledger:
    """The cost of a scene by part and kernel; each operation belongs to one part."""

    model: str
    scene: str
    kernels: tuple[str, ...]  # those with operations
    parts: tuple[Part, ...]
    totals: dict[str, int]  # kernel → operations, the sum over the parts
    left_out: tuple[tuple[str, str], ...]  # (name, kind) of the elements that do not take part
    outputs: tuple[OutputEntry, ...]  # those that the scene reports or could report, and why
    # Time of an evaluation of `accelerations`, measured separately; those of the parts add up to it
    # but for the noise of the measurement.
    nanoseconds: float | None = None
    run: RunCosts | None = None
    loops: str = ""  # which kernels are in loops, and why

    @property
    def title(self) -> str:
        """Machine and scene."""
        return f"{self.model}, scene {self.scene}"

    @property
    def parts_nanoseconds(self) -> float:
        """Sum of the times of the parts."""
        return sum(part.nanoseconds or 0.0 for part in self.parts)

    @property
    def whole(self) -> Part:
        """All parts as one."""
        time = None if self.nanoseconds is None else self.parts_nanoseconds
        events = tuple(event for part in self.parts for event in part.events)
        return Part("total", "", "", True, "", self.totals, nanoseconds=time, events=events)


@dataclass(frozen=True)
class Difference:
    """A part in two scenes."""

    name: str
    acts: tuple[bool | None, bool | None]  # whether it is in; None: unknown to the scene's ledger
    accelerations: tuple[int, int]  # operations of the kernel `accelerations`
    operations: tuple[int, int]  # of all kernels
    nanoseconds: tuple[float | None, float | None]  # of an evaluation of `accelerations`


def compare(first: Ledger, second: Ledger) -> list[Difference]:
    """The parts of two ledgers in the order of declaration, then shared work, then the total."""
    sides = [{part.name: part for part in ledger.parts} for ledger in (first, second)]
    names = dict.fromkeys(chain(*sides))
    shared = {name for side in sides for name, part in side.items() if part.role == "shared"}
    ordered = sorted(names, key=lambda name: name in shared)
    rows = [_difference(name, *(side.get(name) for side in sides)) for name in ordered]
    return [*rows, replace(_difference("total", first.whole, second.whole), acts=(None, None))]


def _difference(name: str, one: Part | None, other: Part | None) -> Difference:
    absent = Part(name, "", "", False, "")
    a, b = one or absent, other or absent
    return Difference(
        name, (one.acts if one else None, other.acts if other else None), (a.solving, b.solving),
        (a.total, b.total), (a.nanoseconds, b.nanoseconds),
    )  # fmt: skip


class Inventory:
    """The parts of a model, and why each takes part in a scene or does not."""

    def __init__(self, model: Model, scene: Scene) -> None:
        self.model, self.scene = model, scene
        self.how = dict(scene.request.fidelity)
        named = [e for e in scene.request.effects if e not in scene.request.without]
        self.choices = {g: model.choice(g, self.how, named) for g in model.groups}
        self.joints = parts_of(model, scene).joints

    def parts(self) -> Iterator[Part]:
        """Joints, drivers, effects, then the fidelities, without their costs."""
        yield from map(self._joint, self.model.joints.values())
        for name, driver in self.model.drivers.items():
            acts = name in self.scene.drivers
            reason = self._named if acts else self._absent
            yield Part(name, driver.kind, "driver", acts, reason(name))
        yield from map(self._effect, self.model.effects)
        yield from self._fidelities()

    def _joint(self, joint: Constraint) -> Part:
        name, scene = joint.name, self.scene
        acts = name in self.joints
        stands_for = replaced_body(joint)
        missing = [b.name for b in joint.bodies if b.name not in ("ground", *scene.bodies)]
        if acts:
            why = "its bodies take part"
            if stands_for is not None:
                why = f"'{stands_for.name}' is taken as '{self.how.get(stands_for.name, 'link')}'"
        elif reason := self._other_choice(name):
            why = reason
        elif missing and missing[0] in self.model.couplers and self.how.get(missing[0]):
            why = f"'{missing[0]}' is taken as '{self.how[missing[0]]}'"
        elif missing:
            why = f"unreachable: body '{missing[0]}' takes no part"
        elif stands_for is not None and stands_for.name in scene.bodies:
            why = f"stands for body '{stands_for.name}', which takes part"
        else:
            why = "the scene leaves it out"
        return Part(name, joint.kind, "joint", acts, why)

    def _effect(self, name: str) -> Part:
        scene = self.scene
        effect = self.model.effects[name]
        named = name in scene.effects
        acts = named and (scene.analysis != "kinematics" or effect.kind == TRACKED)
        if acts:
            kind = self.model.acting(scene)[name].kind
            word = f", as '{self.how[name]}'" if name in self.how else ""
            return Part(name, kind, "effect", True, self._named(name) + word)
        why = self._absent(name)
        if named:
            why = "named, but a kinematic scene has no forces"
        elif self.how.get(name) == NONE:
            why = f"the fidelity '{NONE}' is chosen"
        return Part(name, effect.kind, "effect", False, why)

    def _named(self, name: str) -> str:
        """Why an effect or driver acts."""
        if name in (*self.scene.request.effects, *self.scene.request.drivers):
            return "named by the scene"
        for group, choices in self.model.groups.items():
            if name in choices[self.choices[group]]:
                return f"'{self.choices[group]}' of '{group}' is chosen"
        return "needed by an output"

    def _absent(self, name: str) -> str:
        """Why an effect or driver does not act."""
        element = self.model.effects.get(name) or self.model.drivers[name]
        owners = [body.name for body in element.bodies if not body.fixed]
        law = friction_law(element) if isinstance(element, Effect) else None
        owners += [law.joint] if law else []
        lacking = [o for o in owners if o not in (*self.scene.bodies, *self.joints)]
        if reason := self._other_choice(name):
            return reason
        if lacking:
            kind = self.model.kind(lacking[0])
            return f"unreachable: {kind} '{lacking[0]}' takes no part"
        if name in self.scene.request.without:
            return "the scene leaves it out"
        return "the scene does not name it"

    def _other_choice(self, name: str) -> str | None:
        for group, choices in self.model.groups.items():
            chosen = self.choices[group]
            if name not in choices[chosen] and any(name in names for names in choices.values()):
                return f"'{chosen}' of '{group}' is chosen"
        return None

    def _fidelities(self) -> Iterator[Part]:
        for name, forms in self.model.fidelities.items():
            taken = self.model.acting(self.scene).get(name)
            declared = self.model.effects[name]
            whole = next((w for w, form in forms.items() if form is (taken or declared)), None)
            for word, form in forms.items():
                acts = taken is not None and self.scene.analysis != "kinematics" and word == whole
                why = f"'{whole}' is chosen" if taken is not None else f"'{name}' does not act"
                yield self._word(name, word, acts, f"it {form}" if isinstance(form, str) else why)
        chosen = {name: self.how.get(name, FORMS[0]) for name in self.model.couplers} | self.choices
        for name, taken_word in chosen.items():
            for word in dict.fromkeys(self.model.groups.get(name, FORMS)):
                yield self._word(name, word, word == taken_word, f"'{taken_word}' is chosen")

    def _word(self, name: str, word: str, acts: bool, otherwise: str) -> Part:
        """A word that a fidelity may take."""
        taken = "chosen by the scene" if name in self.how else "as declared"
        return Part(f"{name}: {word}", "fidelity", "fidelity", acts, taken if acts else otherwise)


def output_inventory(model: Model, scene: Scene) -> tuple[OutputEntry, ...]:
    """The groups of outputs, and those of single elements that the scene names."""
    entries = []
    for word in GROUPS:
        named = scene.outputs or (DEFAULT,)
        reported = word in named or (DEFAULT in named and word in ALL)
        why = "named by the scene" if reported else "the scene does not name it"
        if scene.outputs is None:
            why = "reported where no output is named" if reported else "not reported unless named"
        if word not in OF_ANALYSIS[scene.analysis]:
            kinematic = scene.analysis == "kinematics"
            lacks = "a kinematic scene has no masses and no forces"
            reported, why = False, lacks if kinematic else "a scene for equilibrium has no motion"
        entries.append(OutputEntry(word, reported, why))
    single = [word for word in scene.outputs or () if word not in (DEFAULT, *GROUPS)]
    return (*entries, *(OutputEntry(word, True, "named by the scene") for word in single))


def loops_sentence(lowered: Lowered) -> str:
    """Which kernels a build has in loops, their statements before and after; or why none is."""
    program = lowered.program
    sizes = {kernel.name: statements(program, kernel) for kernel in program.kernels}
    total = sum(sizes.values())
    if total <= LONGEST:
        return f"written out: {total} statements, not above {LONGEST}"
    texts = kernel_texts(program, Arguments.of(lowered.description), "auto")
    rolled = [
        f"{text.kernel.name} ({sizes[text.kernel.name]} statements, {text.rolled.statements} left)"
        for text in texts
        if isinstance(text, RolledKernelText)
    ]
    head = f"{total} statements, above {LONGEST}"
    if not rolled:
        return f"written out: {head}, but no kernel repeats itself"
    return f"in loops: {', '.join(rolled)}: {head}; written out: what repeats too little"


def explain(
    model: str | Path | Model, scene: str | Scene | None = None, *, measure: bool = False,
    t_end: float | None = None, progress: Progress = lambda message: None,
) -> tuple[Ledger, ...]:  # fmt: skip
    """Ledgers of one scene of a model, or of all.

    Parameters
    ----------
    model, scene
        As for `build`.
    measure
        Compile the parts of `accelerations` and time them: some seconds a scene.
    t_end
        Also run the scene for this many seconds with its defaults, and report the time that the run
        spent on each part; kernels are then timed at states along the run. The scene must be
        declared in a file.

    Raises
    ------
    InputError
        As `build` does; or if the scene cannot be run.
    """
    file = read_model(model)
    ledgers = []
    for chosen in valid_scenes(file.model, scene):
        if t_end is not None and (file.path is None or chosen.root is not None):
            raise InputError(
                f"scene '{chosen.name}' is not declared in a file, and a run needs the names of "
                "both; declare the scene, or explain it without a run."
            )
        clock = Clock({}, progress, f"{file.model.name}, scene {chosen.name}")
        ledger, programs = _ledger(file.model, chosen, clock)
        if measure or t_end is not None:
            from codegen.explain.element_times import with_times  # numba only to time something

            ledger = with_times(ledger, programs, file.path, t_end, progress)
        ledgers.append(ledger)
    return tuple(ledgers)


def _ledger(model: Model, scene: Scene, clock: Clock) -> tuple[Ledger, tuple[Lowered, ...]]:
    """A ledger without times, and the programs that it is made from."""
    equations, lowered, _ = translate(model, scene, clock)
    programs = costs.cumulative_programs(lowered)
    counts = costs.operations_by_part(programs)
    totals = costs.operations_of(programs[-1])
    parts = []
    for part in Inventory(model, scene).parts():
        effect = part.acts and part.role == "effect"
        own = costs.marginal_operations(programs[-1], part.name) if effect else {}
        events = tuple(s.text for s in equations.switches if s.effect == part.name)
        added = counts.pop(part.name, {}) if part.acts else {}  # a joint's with its point's
        parts.append(replace(part, operations=added, own=own, events=events))
    parts += [
        Part(name or "sums", SHARED.get(name, "shared"), "shared", True, "shared", operations)
        for name, operations in counts.items()
    ]
    kernels, outputs = tuple(k for k in totals if totals[k]), output_inventory(model, scene)
    left_out = equations.left_out
    ledger = Ledger(equations.model, scene.name, kernels, tuple(parts), totals, left_out, outputs)
    ledger = replace(ledger, loops=loops_sentence(programs[-1]))
    return ledger, programs

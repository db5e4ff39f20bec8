"""Every way in which a run can end, and what to try next."""

from enum import IntEnum, unique

from codegen.errors import InputError
from codegen.readers.values import shown


@unique
class Outcome(IntEnum):
    """How a run ended. Everything but `OK` keeps the results up to that time."""

    @classmethod
    def _missing_(cls, value: object) -> None:
        raise InputError(
            f"Outcome({shown(value)}): give the number of an outcome, 0 to {len(cls) - 1}."
        )

    def __str__(self) -> str:
        """The name, not the number."""
        return self.name

    OK = 0
    INCONSISTENT = 1
    ZENO = 2
    STEP_TOO_SMALL = 3
    MAX_STEPS = 4
    NEWTON_FAILED = 5
    SINGULAR = 6
    NOT_FINITE = 7
    INTERRUPTED = 8
    LOCKED = 9
    UNBALANCED = 10
    INACCURATE = 11
    CONTRADICTED = 12
    DISCONTINUOUS = 13
    MEMORY = 14
    OUT_OF_RANGE = 15

    @property
    def of_switch(self) -> bool:
        """Whether it concerns a switching condition, and no constraint."""
        return self in _OF_SWITCH

    @property
    def meaning(self) -> str:
        """What happened, in a sentence."""
        return " ".join(_TEXT[self].split("\n\n")[0].split())

    @property
    def advice(self) -> str:
        """What to try next, in a sentence."""
        return " ".join(_TEXT[self].split("\n\n")[1].split())


@unique
class Site(IntEnum):
    """The place in the program at which a run was ended, where several lead to its outcome."""

    NOWHERE = 0
    START_RANK = 1
    START_NEWTON = 2
    START_WEAK = 3
    START_ASTRAY = 4
    START_MODES = 5
    START_JAM = 6
    START_NOT_FINITE = 7
    ANEW = 8
    WEAK_STATES = 9
    NO_POSITION = 10
    NO_ACCELERATIONS = 11
    STEPS_ACROSS = 12
    NARROW_MISS = 13
    LOCK_UP = 14
    JAM = 15
    SHORTEST_STEP = 16
    ENDLESS_STEPS = 17
    STANDING = 18
    CROWDED_MODES = 19
    CROWDED = 20
    MOST_EVENTS = 21
    EVENT_MODES = 22
    CONDITIONS = 23
    STEP_BALANCE = 24
    EVENT_BALANCE = 25
    CHECKS = 26

    def of(self, subject: str) -> str:
        """The function and what it has found, of a joint, driver or condition; empty of NOWHERE."""
        text = _SITES.get(self, "")
        return f"{text}, of {subject}" if text and subject else text


_SITES = {
    Site.START_RANK: "place_on_constraints: fewer constraints are independent than the machine has",
    Site.START_NEWTON: "place_on_constraints: Newton's method does not reach the constraints",
    Site.START_WEAK: "start: weak pivot in the accelerations of the start",
    Site.START_ASTRAY: "prepare_start: start velocity off every branch",
    Site.START_MODES: "choose_modes: no consistent modes at the start",
    Site.START_JAM: "start: friction that jams at the start",
    Site.START_NOT_FINITE: "start: accelerations of the start that are not finite",
    Site.ANEW: "start_anew: no first step under other laws of time",
    Site.WEAK_STATES: "follow_plan: third weak state in a row",
    Site.NO_POSITION: "_plan_crossing: third weak state in a row, and no singular position near",
    Site.NO_ACCELERATIONS: "_cross: no accelerations by continuity",
    Site.STEPS_ACROSS: "_judge_step_across: failed steps across one position",
    Site.NARROW_MISS: "_follow_miss: a bend too narrow for the tolerance",
    Site.LOCK_UP: "_end_at_lock_up: drivers ask for ever more speed",
    Site.JAM: "end_at_jam: friction or contacts that lock up or jam",
    Site.SHORTEST_STEP: "plan_step: the shortest step was rejected",
    Site.ENDLESS_STEPS: "is_endless: ever shorter steps",
    Site.STANDING: "stay: events in a row without time between them",
    Site.CROWDED_MODES: "judge_events: no consistent modes after ever denser events",
    Site.CROWDED: "judge_events: ever denser events",
    Site.MOST_EVENTS: "judge_events: most events of a run",
    Site.EVENT_MODES: "judge_events: no consistent modes after an event",
    Site.CONDITIONS: "watch: conditions that renew each other without end",
    Site.STEP_BALANCE: "balance_step: energy of steps that no work explains",
    Site.EVENT_BALANCE: "balance_event: energy at an event that no work explains",
    Site.CHECKS: "check_result: a check after the run",
}

_OF_SWITCH = {
    *(Outcome.INCONSISTENT, Outcome.ZENO, Outcome.CONTRADICTED, Outcome.OUT_OF_RANGE),
}

_TEXT = {
    Outcome.OK: """
        The run reached its end.

        Nothing needs to be done.
        """,
    Outcome.INCONSISTENT: """
        No modes of the switching effects are consistent with the motion that follows from them: on
        either side of the switch, forces drive the motion back to the other side, and no sliding or
        sticking was found between them.

        Look for a joint that jams because friction raises its own normal force, a contact that
        works against a driver, two conditions that undo each other, or a body that rests where a
        force jumps with its position; give the friction creep=, the contact stiffness=, that force
        a steep slope in place of its jump, or end the run before this time.
        """,
    Outcome.ZENO: """
        Switching conditions change ever faster, infinitely often in a finite time, with no rest.

        Look at the events before this time; let the effect come to rest (add damping, a clearance
        or a hysteresis), or, if it represents a contact, declare a rigid one, whose bouncing ends;
        of a rigid contact, look at what moves it, or give it stiffness=.
        """,
    Outcome.STEP_TOO_SMALL: """
        The tolerances require a step that the resolution of the clock does not permit, or ever
        shorter steps, which do not come to the end of the run.

        Loosen rtol, give atol a size that matters for the machine, or look for an effect that grows
        without bound, such as a negative or broken power at zero, turns ever faster, or jumps
        without a switching condition, and for two points between which a distance becomes zero.
        """,
    Outcome.MAX_STEPS: """
        The permitted number of steps was used up.

        Raise max_steps, or loosen the tolerances. Where that hardly changes the number of steps,
        the model is stiff: lower its largest stiffness or damping, or make an effect that changes
        abruptly smoother.
        """,
    Outcome.MEMORY: """
        What the run records has used up the memory that it may take.

        Ask for samples at the instants that are needed, with t_eval, in place of the end of every
        step; end the run earlier; or, where the machine has the memory, raise max_bytes. A result
        takes some times as much.
        """,
    Outcome.NEWTON_FAILED: """
        Newton's method did not converge, however short the step: in the return onto the constraints
        or, with an implicit method, in the step.

        Check that the mechanism can move on from here: a driver may require a position that the
        joints do not permit. With radau5 or bdf, run dop853, which tells a force that is not
        finite.
        """,
    Outcome.SINGULAR: """
        The constraints are no longer independent: the mechanism is in a singular position, or one
        of them is redundant.

        Remove the constraint named if it repeats what others demand; otherwise look for a dead
        centre or a lock-up at this position.
        """,
    Outcome.NOT_FINITE: """
        The accelerations are not finite.

        Look in the effects for a division by zero, a root of a negative number, a spring whose ends
        coincide or a mass of zero; in motion laws, curves and effects for a table evaluated beyond
        its ends; in joints with friction for one that jams.
        """,
    Outcome.INTERRUPTED: """
        The user interrupted the run.

        The results up to this time are kept; start again from the last state to go on.
        """,
    Outcome.LOCKED: """
        The mechanism cannot follow its driver any further.

        Change a length or the range of the driver; the position before this time is the last that
        can be reached.
        """,
    Outcome.UNBALANCED: """
        No position was found in which the forces balance.

        Start from a guess nearer to rest, try the other method, or check that something holds the
        machine.
        """,
    Outcome.INACCURATE: """
        Beyond this time the motion cannot be computed to the accuracy asked for.

        Ask for less accuracy or for a shorter time, or simulate with rtol in place of accuracy for
        a motion of which only constraints, energy and means are right.
        """,
    Outcome.OUT_OF_RANGE: """
        The motion leaves the range of a table, beyond which nothing is known.

        Give the table points further out, or say with beyond="hold" or beyond="extrapolate" what
        it is there; or end the run before this time.
        """,
    Outcome.DISCONTINUOUS: """
        An explicit function of time, a law of motion or a force, has no finite value at this time,
        or jumps where a motion cannot.

        Write a law that is continuous, a ramp in place of a step, or an angle that counts its
        turns, 3*t in place of atan2(sin(3*t), cos(3*t)); or end the run before this time.
        """,
    Outcome.CONTRADICTED: """
        A check of the results contradicts the run.

        Do not rely on what comes after the instant that is named. Where an event was missed, give
        max_step, shorter than a condition holds; where joints are open, take smaller tolerances or
        correction="step"; where energy is not balanced, look for a potential or a law of motion
        that jumps there.
        """,
}
"""What happened, then what to try next: two paragraphs."""

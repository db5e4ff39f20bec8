"""Every way in which a run can end, and what to try next."""

from enum import IntEnum, unique
from typing import Any

from codegen.errors import InputError
from codegen.readers.values import shown


@unique
class Outcome(IntEnum):
    """How a run ended. Everything but `OK` keeps the results up to that time.

    An outcome is written as two paragraphs: what happened, its `meaning`, and what to try next, its
    `advice`. Compiled code knows an outcome by its number, which is its place in the list.
    """

    meaning: str
    advice: str

    def __new__(cls, text: Any) -> "Outcome":
        """The outcome of the next number."""
        one = int.__new__(cls, len(cls.__members__))
        one._value_ = int(one)
        one.meaning, one.advice = (" ".join(part.split()) for part in text.split("\n\n"))
        return one

    OK = """
    The run reached its end.

    Nothing needs to be done.
    """
    INCONSISTENT = """
    No modes of the switching effects are consistent with the motion that follows from them: on
    either side of the switch, forces drive the motion back to the other side, and no sliding or
    sticking was found between them.

    Look for a joint that jams because friction raises its own normal force, a contact that
    works against a driver, two conditions that undo each other, or a body that rests where a
    force jumps with its position; give the friction creep=, the contact stiffness=, that force
    a steep slope in place of its jump, or end the run before this time.
    """
    ZENO = """
    Switching conditions change ever faster, infinitely often in a finite time, with no rest.

    Look at the events before this time; let the effect come to rest (add damping, a clearance
    or a hysteresis), or, if it represents a contact, declare a rigid one, whose bouncing ends;
    of a rigid contact, look at what moves it, or give it stiffness=.
    """
    STEP_TOO_SMALL = """
    The tolerances require a step that the resolution of the clock does not permit, or ever
    shorter steps, which do not come to the end of the run.

    Loosen rtol, give atol a size that matters for the machine, or look for an effect that grows
    without bound, such as a negative or broken power at zero, turns ever faster, or jumps
    without a switching condition, and for two points between which a distance becomes zero.
    """
    MAX_STEPS = """
    The permitted number of steps was used up.

    Raise max_steps, or loosen the tolerances. Where that hardly changes the number of steps,
    the model is stiff: lower its largest stiffness or damping, or make an effect that changes
    abruptly smoother.
    """
    NEWTON_FAILED = """
    Newton's method did not converge, however short the step: in the return onto the constraints
    or, with an implicit method, in the step.

    Check that the mechanism can move on from here: a driver may require a position that the
    joints do not permit. With radau5 or bdf, run dop853, which tells a force that is not
    finite.
    """
    SINGULAR = """
    The constraints are no longer independent: the mechanism is in a singular position, or one
    of them is redundant.

    Remove the constraint named if it repeats what others demand; otherwise look for a dead
    centre or a lock-up at this position.
    """
    NOT_FINITE = """
    The accelerations, a force or an output are not finite.

    Look in the effects for a division by zero, a root of a negative number, a spring whose ends
    coincide or a mass of zero; in motion laws, curves and effects for a table evaluated beyond
    its ends; in joints with friction for one that jams.
    """
    INTERRUPTED = """
    The user interrupted the run.

    The results up to this time are kept; start again from the last state to go on.
    """
    LOCKED = """
    The mechanism cannot follow its driver any further.

    Change a length or the range of the driver; the position before this time is the last that
    can be reached.
    """
    UNBALANCED = """
    No position was found in which the forces balance.

    Start from a guess nearer to rest, try the other method, or check that something holds the
    machine.
    """
    INACCURATE = """
    Beyond this time the motion cannot be computed to the accuracy asked for.

    Ask for less accuracy or for a shorter time, or simulate with rtol in place of accuracy for
    a motion of which only constraints, energy and means are right.
    """
    CONTRADICTED = """
    A check of the results contradicts the run.

    Do not rely on what comes after the instant that is named. Where an event was missed, give
    max_step, shorter than a condition holds; where joints are open, take smaller tolerances or
    correction="step"; where energy is not balanced, look for a potential or a law of motion
    that jumps there.
    """
    DISCONTINUOUS = """
    An explicit function of time, a law of motion or a force, has no finite value at this time,
    or it, its rate or the slope of a joint's equation jumps where a motion cannot.

    Let what the message names be continuous: a law by a ramp in place of a step, the rate of a
    place by a ramp with rounded ends, an angle by one that counts its turns, 3*t in place of
    atan2(sin(3*t), cos(3*t)). Keep a joint away from its kink; or end the run before this time.
    """
    MEMORY = """
    What the run records has used up the memory that it may take.

    Ask for samples at the instants that are needed, with t_eval, in place of the end of every
    step; end the run earlier; or, where the machine has the memory, raise max_bytes. A result
    takes some times as much.
    """
    OUT_OF_RANGE = """
    The motion leaves the range of a table, beyond which nothing is known.

    Give the table points further out, or say with beyond="hold" or beyond="extrapolate" what
    it is there; or end the run before this time.
    """

    @classmethod
    def _missing_(cls, value: object) -> None:
        raise InputError(
            f"Outcome({shown(value)}): give the number of an outcome, 0 to {len(cls) - 1}."
        )

    def __str__(self) -> str:
        """The name, not the number."""
        return self.name

    @property
    def of_switch(self) -> bool:
        """Whether it concerns a switching condition, and no constraint."""
        return self in _OF_SWITCH


_OF_SWITCH = {Outcome.INCONSISTENT, Outcome.ZENO, Outcome.CONTRADICTED, Outcome.OUT_OF_RANGE}


@unique
class Site(IntEnum):
    """The place in the program at which a run was ended, where several lead to its outcome."""

    text: str

    def __new__(cls, text: Any) -> "Site":
        """The site of the next number: the function, and what it has found."""
        one = int.__new__(cls, len(cls.__members__))
        one._value_, one.text = int(one), text
        return one

    NOWHERE = ""
    START_RANK = "place_on_constraints: fewer constraints are independent than the machine has"
    START_NEWTON = "place_on_constraints: Newton's method does not reach the constraints"
    START_WEAK = "start: weak pivot in the accelerations of the start"
    START_ASTRAY = "prepare_start: start velocity off every branch"
    START_MODES = "choose_modes: no consistent modes at the start"
    START_JAM = "start: friction that jams at the start"
    START_NOT_FINITE = "start: accelerations of the start that are not finite"
    ANEW = "start_anew: no first step under other laws of time"
    WEAK_STATES = "follow_plan: third weak state in a row"
    NO_POSITION = "_plan_crossing: third weak state in a row, and no singular position near"
    NO_ACCELERATIONS = "_cross: no accelerations by continuity"
    STEPS_ACROSS = "_judge_step_across: failed steps across one position"
    NARROW_MISS = "_follow_miss: a bend too narrow for the tolerance"
    LOCK_UP = "_end_at_lock_up: drivers ask for ever more speed"
    JAM = "end_at_jam: friction or contacts that lock up or jam"
    SHORTEST_STEP = "plan_step: the shortest step was rejected"
    KINK = "try_step: a place where the equation of a constraint is not smooth"
    ENDLESS_STEPS = "is_endless: ever shorter steps"
    STANDING = "stay: events in a row without time between them"
    CROWDED_MODES = "judge_events: no consistent modes after ever denser events"
    CROWDED = "judge_events: ever denser events"
    MOST_EVENTS = "judge_events: most events of a run"
    EVENT_MODES = "judge_events: no consistent modes after an event"
    CONDITIONS = "watch: conditions that renew each other without end"
    STEP_BALANCE = "balance_step: energy of steps that no work explains"
    EVENT_BALANCE = "balance_event: energy at an event that no work explains"
    CHECKS = "check_result: a check after the run"

    def of(self, subject: str) -> str:
        """The function and what it has found, of a joint, driver or condition; empty of NOWHERE."""
        return f"{self.text}, of {subject}" if self.text and subject else self.text

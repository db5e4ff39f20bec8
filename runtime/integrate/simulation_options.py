"""Options of a simulation: the arguments of `Machine.simulate` as data, for cases and commands.

Their meaning in full is in the documentation of `Machine.simulate`.
"""

from typing import NamedTuple

from runtime.integrate.method import METHODS, alternatives


class SimulationOption(NamedTuple):
    """A word of `Machine.simulate`."""

    name: str
    kind: str  # "number", "seconds", "count", "text", "names", "conditions" or "instants"
    about: str
    default: str | None = None
    of_commands: bool = True  # whether it is one of the options that all commands share
    of_studies: bool = True  # whether a study hands it to its runs unread


OPTIONS = (
    SimulationOption("t_end", "seconds", "Last instant, s.", None, False, False),
    SimulationOption("t_eval", "instants", "Number of output instants, the instants, or steps.",
                     None, False, False),
    SimulationOption("t_start", "seconds", "First instant, s.", None, False, False),
    SimulationOption("accuracy", "number",
                     "Relative global error that the result may have, in place of tolerances; the "
                     "program chooses all other options that are not given.", None, True, False),
    SimulationOption("quantities", "names",
                     "With accuracy: series whose error counts; all coordinates and velocities "
                     "unless given.", None, True, False),
    SimulationOption("method", "text",
                     f"Integration method: {alternatives(METHODS)}; dop853 unless given.",
                     None, True, False),
    SimulationOption("rtol", "number", "Relative tolerance of a step; 1e-8 unless given.",
                     None, True, False),
    SimulationOption("atol", "number", "Absolute tolerance in SI units."),
    SimulationOption("correction", "text",
                     "Return onto the constraints: step, stage, projection, baumgarte or hybrid.",
                     "step"),
    SimulationOption("time_scale", "seconds",
                     "Time of Baumgarte's accelerations in s; a thousandth of the run unless "
                     "given."),
    SimulationOption("formulation", "text",
                     "Coordinates that are integrated: cartesian (all of them, the default) or "
                     "reduced (those that no constraint determines).", None, True, False),
    SimulationOption("first_step", "seconds", "Length of the first step in s; chosen unless "
                     "given."),
    SimulationOption("max_step", "seconds", "Longest step in s; none unless given."),
    SimulationOption("until", "conditions",
                     "Conditions on series; the run ends where one begins to hold."),
    SimulationOption("max_steps", "count",
                     "Most trial steps; unless given 100 million, or fewer if steps shrink."),
    SimulationOption("max_bytes", "count", "Bytes of recorded states; 1 GiB unless given.",
                     None, False),
)  # fmt: skip
"""Those that are data: not values by name, and no functions."""

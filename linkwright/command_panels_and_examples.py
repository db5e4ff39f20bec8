"""The commands of `linkwright` in the panels of its help, and an example of each.

An example runs as it stands in a folder with `four_bar.py`, which `linkwright new four_bar` writes,
unless it names a model of the library.
"""

PANELS = {
    "Declare": {
        "new": "Write a commented model to start from.",
        "list": "List models and their scenes.",
        "elements": "List joints, drivers and forces, or show the page of one.",
        "check": "Find everything that is wrong with a declaration.",
        "draw": "Draw a machine.",
    },
    "Compile": {
        "build": "Compile the kernels of a model's scenes.",
        "explain": "Explain the parts of a scene and their cost.",
        "precompile": "Compile the runtime ahead of the first run.",
        "methods": "Write the explicit integration methods of the runtime.",
    },
    "Analyse": {
        "equilibrium": "Where does it rest?",
        "kinematics": "How must it move?",
        "inverse": "What does it take to move it so?",
        "inverse-dynamics": "The same as inverse.",
        "simulate": "How will it move?",
    },
    "Study": {
        "accuracy": "What does each digit of a run cost?",
        "matters": "Which effects does a quantity need?",
        "sweep": "Run a scene for many values of its parameters.",
    },
    "Show": {"report": "Write a page about a run."},
}
"""Panel → its commands in the order of the help, each with its line there."""

KINDS = ("four-bar", "slider-crank", "pendulum", "cam-follower")
"""Kinds of models to start from: each is a file of `linkwright/templates`."""

EXAMPLES: dict[str, tuple[str, ...]] = {
    "": (
        "linkwright new four_bar",
        "linkwright check four_bar.py",
        "linkwright draw four_bar.py --out four_bar.png",
        "linkwright simulate four_bar.py --t-end 5 --out run.nc",
        "linkwright report four_bar.py --t-end 5 --out run.html",
    ),
    "new": (
        "linkwright new four_bar",
        "linkwright new press --kind slider-crank",
    ),
    "list": ("linkwright list", "linkwright list ."),
    "elements": (
        "linkwright elements",
        "linkwright elements revolute",
        "linkwright elements one-way-clutch",
    ),
    "check": (
        "linkwright check four_bar.py",
        "linkwright check four_bar.py --scene driven --json",
    ),
    "draw": (
        "linkwright draw four_bar.py --out four_bar.png",
        "linkwright draw four_bar.py --scene driven --t 0.25 --forces --out quarter.svg",
    ),
    "build": (
        "linkwright build four_bar.py",
        "linkwright build four_bar.py --scene swing --tangents",
        "linkwright build four_bar.py slider_crank.py --check",
    ),
    "explain": (
        "linkwright explain four_bar.py",
        "linkwright explain four_bar.py --scene swing --run 1",
    ),
    "precompile": ("linkwright precompile", "linkwright precompile dop853 radau5"),
    "methods": ("linkwright methods --check",),
    "equilibrium": ("linkwright equilibrium four_bar.py --scene swing",),
    "kinematics": ("linkwright kinematics four_bar.py --scene driven --t-end 1 --out motion.csv",),
    "inverse": ("linkwright inverse four_bar.py --scene driven --t-end 1 --out torque.csv",),
    "inverse-dynamics": ("linkwright inverse-dynamics four_bar.py --scene driven --t-end 1",),
    "simulate": (
        "linkwright simulate four_bar.py --t-end 5 --out run.nc",
        "linkwright simulate four_bar.py --t-end 5 --set AB=0.08 --json",
        "linkwright simulate four_bar.py --t-end 5 --accuracy 1e-6",
    ),
    "accuracy": ("linkwright accuracy four_bar.py --scene swing --t-end 1 --quick",),
    "matters": (
        "linkwright matters four_bar.py --scene swing --t-end 2 --quantity max:rocker.phi",
    ),
    "sweep": (
        "linkwright sweep four_bar.py --t-end 2 --over AB=0.06:0.1:9 --quantity C.fx --out s.zarr",
    ),
    "report": ("linkwright report four_bar.py --t-end 5 --out run.html",),
}
"""Command → example lines; those of "" stand below the list of all commands."""


def panel_and_line(command: str) -> tuple[str | None, str | None]:
    """The panel of a command and its line there; None where the table has none."""
    named = ((panel, names[command]) for panel, names in PANELS.items() if command in names)
    return next(named, (None, None))

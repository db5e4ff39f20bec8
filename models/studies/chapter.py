"""The studies of the chapters: which machine, which scenes, what is tabulated and drawn.

A study is a module of this package with the functions ``table() -> list[Row]``, and of a second
one, its name with ``_figures``, with ``figures()``: an iterator of (number in the book, picture).
They run the machine, and are imported only when its scenes are built.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from models.studies.rows import Row

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MODELS = Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class Study:
    """One machine and what the book asks of it.

    Attributes
    ----------
    name
        The module of this package.
    title
        What a person calls it.
    machine
        The file in ``models/``, without its ending.
    scenes
        Those that the study runs.
    """

    name: str
    title: str
    machine: str
    scenes: tuple[str, ...]

    @property
    def path(self) -> Path:
        """The declaration."""
        return MODELS / f"{self.machine}.py"

    def table(self) -> list[Row]:
        """Ours, exact, book."""
        rows: list[Row] = import_module(f"models.studies.{self.name}").table()
        return rows

    def figures(self) -> "Iterator[tuple[str, Figure]]":
        """(number in the book, picture)."""
        yield from import_module(f"models.studies.{self.name}_figures").figures()


STUDIES = (
    Study(
        "compressor",
        "the compressor of section 8.2",
        "slider_crank",
        (
            *("gravity_equilibrium", "gas_equilibrium", "gas_equilibrium_as_printed"),
            *("kinematics", "inverse_dynamics", "inverse_dynamics_without_gas", "compressor"),
        ),
    ),
    Study(
        "quick_return",
        "the shaper of section 8.3",
        "quick_return",
        (
            *("gravity_equilibrium", "kinematics", "inverse_dynamics"),
            *("inverse_dynamics_of_inertia", "shaper"),
        ),
    ),
    Study(
        "coil_spring",
        "the coil spring of section 8.4",
        "coil_spring",
        ("surge", "impact", "impact_damped"),
    ),
    Study(
        "valve_lifter",
        "the valve lifter of section 8.5",
        "valve_lifter",
        ("kinematics", "inverse_dynamics", "free_follower"),
    ),
    Study(
        "film_follower",
        "the film follower of project 8.1",
        "film_follower",
        ("kinematics", "inverse_dynamics", "constant_torque", "motor"),
    ),
    Study(
        "web_cutter",
        "the web cutter of project 8.2",
        "web_cutter",
        ("kinematics", "inverse_dynamics", "running"),
    ),
    Study(
        "four_bar",
        "the four-bar linkage of section 5.3",
        "four_bar",
        ("kinematics", "inverse_dynamics", "constant_torque"),
    ),
    Study(
        "rack_and_pinion",
        "the rack and pinion of project 8.3",
        "rack_and_pinion",
        (
            *("kinematics", "kinematics_massless_coupler", "inverse_dynamics"),
            *("inverse_dynamics_massless_coupler", "running", "running_massless_coupler"),
        ),
    ),
    Study(
        "gear_slider",
        "the gear-slider mechanisms of section 5.5",
        "gear_slider",
        (
            *("train_kinematics", "train_inverse_dynamics", "train_running"),
            *("planetary_kinematics", "planetary_inverse_dynamics"),
        ),
    ),
    Study(
        "spatial_slider_crank",
        "the spatial slider-crank of section 12.2",
        "space/spatial_slider_crank",
        ("inverse_dynamics",),
    ),
    Study(
        "spatial_four_bar",
        "the spatial four-bar of section 12.3",
        "space/spatial_four_bar",
        ("inverse_dynamics", "inverse_dynamics_without_link"),
    ),
    Study(
        "swash_plate_compressor",
        "the air compressor of section 12.4",
        "space/swash_plate_compressor",
        ("kinematics",),
    ),
    Study("governor", "the governor of section 12.6", "space/governor", ("run",)),
)

"""Pages of the library's machines in motion, one a machine."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from models.studies.compressor import FLYWHEELS
from runtime import Result, animate, load


class Shown(NamedTuple):
    """What a page shows: a run of a scene up to an instant, or one for each set of parameters."""

    scene: str
    t_end: float
    parameters: tuple[dict[str, float], ...] = ({},)


MACHINES = {
    "slider_crank": Shown("compressor", 2.0, tuple({"J1": inertia} for inertia in FLYWHEELS)),
    "coil_spring": Shown("impact", 18.0),
    "engine": Shown("firing", 0.5),
    "film_follower": Shown("motor", 2.0),
    "four_bar": Shown("constant_torque", 2.0),
    "gear_slider": Shown("train_running", 2.0),
    "quarter_car": Shown("bump", 2.0),
    "quick_return": Shown("shaper", 2.0),
    "rack_and_pinion": Shown("running", 4.0),
    "robot_arm": Shown("continuous", 2.0),
    "scotch_yoke": Shown("running", 2.0),
    "trebuchet": Shown("throw", 1.6),
    "valve_lifter": Shown("free_follower", 0.1),
    "watt_six_bar": Shown("constant_torque", 2.0),
    "web_cutter": Shown("running", 4.0),
    "space/bricard": Shown("fall", 4.0),
    "space/double_wishbone": Shown("guided", 1.0),
    "space/flyball_governor": Shown("run", 10.0),
    "space/governor": Shown("run", 10.0),
    "space/gyroscope": Shown("precession", 3.0),
    "space/heavy_top": Shown("spin", 3.0),
    "space/scara": Shown("inverse_dynamics", 2.0),
    "space/six_revolute_arm": Shown("inverse_dynamics", 2.0),
    "space/spatial_four_bar": Shown("inverse_dynamics", 2.0),
    "space/spatial_slider_crank": Shown("free", 2.0),
    "space/stewart_platform": Shown("legs", 2.0),
    "space/swash_plate_compressor": Shown("kinematics", 0.2),
    "space/universal_joint": Shown("driven", 6.2832),
}
"""Machine → what its page shows."""


def runs(machine: str) -> list[Result]:
    """The runs of a machine's page."""
    shown = MACHINES[machine]
    loaded = load(machine, shown.scene)
    run = loaded.kinematics if shown.scene == "kinematics" else loaded.simulate
    return [run(shown.t_end, parameters=values) for values in shown.parameters]


def write_pages(
    machines: Iterable[str], folder: Path, progress: Callable[[str], object] = str
) -> Iterator[Path]:
    """Write the pages into a folder, and answer their places."""
    folder.mkdir(parents=True, exist_ok=True)
    for machine in machines:
        progress(f"animating {machine}")
        yield animate(runs(machine)).save(folder / f"{Path(machine).name}.html")

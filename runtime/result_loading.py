"""Results from files: the `Result` that was saved, with its machine.

A file executes nothing, and names no file that is executed: its machine is the one that is given,
or one that this process has loaded.
"""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.errors import FAILURES, InputError, LinkwrightError
from codegen.files.generated_modules import content_hash
from codegen.readers import arguments as readers
from codegen.readers.values import one_line
from runtime.core.outcomes import Outcome
from runtime.dynamics.joined_runs import joined
from runtime.dynamics.motion_at_instants import SimulatedMotion, simulated_again, start_again
from runtime.dynamics.output_quantities import evaluate
from runtime.dynamics.prescribed_motion import DrivenMotionAtInstants
from runtime.integrate.problem import Discrete
from runtime.machine_loading import LOADED
from runtime.mechanism.dense_equations import Equations
from runtime.mechanism.mechanism import Mechanism, seeking, sibling, sibling_named
from runtime.results.export import require_libraries
from runtime.results.motion_at_instants import keep
from runtime.results.result import Result
from runtime.results.run_records import Reconnection
from runtime.results.saved_result import (
    FACTS,
    GROUP,
    KINDS,
    OF_ONE_RUN,
    events_of,
    floats,
    partitions_of,
    samples_of,
    unpack,
)
from runtime.results.zarr_store import read_content
from runtime.validation.arguments import parameter_values

if TYPE_CHECKING:
    from runtime.machine_facade import Machine

_machine = readers.instance("runtime.machine_facade", "Machine", "a machine, as load() makes it")


@readers.reads(path=readers.path, machine=readers.optional(_machine))
def load_result(path: str | os.PathLike[str], machine: "Machine | None" = None) -> "Result":
    """Return the result that `Result.save` wrote into a .nc file or a .zarr store.

    The machine computes the quantities again from the states, with the same bits. `Result.at` and
    `Result.resume` repeat the run from its start, since files have no checkpoints: they return the
    same bits, after as long as the run took. They fail for a run with your own functions in
    `controllers=`, which no file keeps: simulate anew. An `Equilibrium` is read as a plain result.

    Parameters
    ----------
    path
        A file ending in .nc or a store ending in .zarr, in any folder.
    machine
        The machine of the result; by default the loaded machine of the same model and scene. For an
        equilibrium, whose file does not have the hash of its model, it must be given.

    Raises
    ------
    InputError
        If the file cannot be read or was not written by `Result.save`, if the model has changed, or
        if `machine` is not given and no machine of the result's scene is loaded.
    """
    place = Path(path)
    try:
        saved = unpack(_content(place), [*KINDS, Discrete])
        return _result(_mechanism_of(place, saved, machine), saved)
    except LinkwrightError:
        raise
    except FAILURES as error:
        raise InputError(
            f"{place} was not written by this version of Result.save, or is damaged "
            f"({type(error).__name__}). Read the numbers alone with xarray."
        ) from error


def _content(path: Path) -> bytes:
    """What `Result.save` wrote beside the series."""
    ending = path.suffix.lower()
    if ending not in (".nc", ".zarr"):
        raise InputError(
            f"{path}: results come back from .nc files and .zarr stores alone, as Result.save "
            "writes them."
        )
    if not path.exists():
        raise InputError(f"{path}: there is no such file.")
    require_libraries(path, "reading")
    if ending == ".zarr":
        return read_content(path)
    import netCDF4

    with netCDF4.Dataset(path) as file:
        return np.asarray(file.groups[GROUP].variables[GROUP][:], np.uint8).tobytes()


def _mechanism_of(path: Path, saved: dict[str, Any], machine: "Machine | None") -> Mechanism:
    """The mechanism of a result: of the machine that is given, or of one that is loaded."""
    source = saved["motion"] and saved["motion"]["source"]
    content, file = (source["content"], source["model"]) if source else (None, "")
    title, known = saved["title"], [*LOADED] if machine is None else [machine.mechanism]
    model, _, scene = title.partition("/")
    near = [one for one in known if one.description.model == model]
    if unknown := (saved["motion"] or {}).get("unknown"):
        scene = scene.removesuffix(f"_unknown_{'_'.join(unknown)}")
    found = [one for one in (sibling_named(one, scene) for one in near) if one is not None]
    found = [seeking(one, unknown) for one in found] if unknown else found
    if machine is not None and not found:
        raise InputError(
            f"{path} has a result of {title}, and the machine is {machine.description.title}."
        )
    if not found:
        raise InputError(
            f"{path} has a result of {one_line(title)}, whose machine is not loaded. Load it "
            f"({one_line(file or 'the model')}, scene {one_line(scene)}) and give it: "
            "load_result(path, machine=load(...)); or read the numbers alone with xarray."
        )
    if machine is None and content is None:  # nothing tells whether a loaded machine is that one
        raise InputError(
            f"{path} does not say from which text the machine of {one_line(title)} came, as that "
            "of an equilibrium does not. Give it: load_result(path, machine=load(...))."
        )
    for one in found:
        origin = one.origin
        if origin is None or content in (None, content_hash(origin.text)):
            return one
    raise InputError(
        f"{path}: the model of {title}, or the generator, has changed since the result was saved, "
        f"so that {found[-1].path} computes something else. Load the machine as it was, and give "
        "it as machine=; or read the numbers alone with xarray."
    )


def _result(mechanism: Mechanism, saved: dict[str, Any]) -> Result:
    """The result of a machine that was saved."""
    kept, parameters = saved["motion"], saved["parameters"]
    if kept is not None and "parts" in kept:
        return _joined(mechanism, saved)
    p = parameter_values(mechanism, parameters)
    motion: SimulatedMotion | DrivenMotionAtInstants | None = None
    equations = Equations(mechanism, p)
    states = samples_of(saved["samples"], mechanism.description)
    if kept is not None:
        q, v = (floats(kept[name], states[name].shape[1:], name) for name in "qv")
        start = start_again(mechanism, p, kept["t"], q, v)
        if saved["analysis"] == "simulation":
            motion = simulated_again(mechanism, p, start, parameters, kept)
            equations = motion.coordinates.equations
        else:
            preferred = floats(kept["preferred"], start.q.shape, "preferred")
            times = floats(kept["times"], (-1,), "times")
            motion = DrivenMotionAtInstants(mechanism, p, start, preferred, times)
            equations = motion.equations
    return Result(
        mechanism.description, evaluate(equations, **states), p,
        outcome=Outcome[saved["outcome"]], events=events_of(saved["events"]),
        partitions=partitions_of(saved["partitions"]), singular=tuple(saved["singular"]),
        site=saved.get("site", ""),  # of older files unknown
        _until=tuple(saved["until"]), _motion=motion, _mechanism=mechanism,
        **{name: saved[name] for name in (*FACTS, *OF_ONE_RUN)},
    )  # fmt: skip


def _joined(mechanism: Mechanism, saved: dict[str, Any]) -> Result:
    """The result of several runs, with other joints each."""
    kept, outcome = saved["motion"], Outcome[saved["outcome"]]
    results, since, told = [], kept["since"], kept.get("told", 0)
    # of older files one joint, or None
    changes = [(one,) if isinstance(one, Reconnection) else one or () for one in kept["changes"]]
    for part, change in zip(kept["parts"], [(), *changes], strict=True):
        if change:
            mechanism = sibling(mechanism, (one.joint for one in change))
        results.append(_result(mechanism, part))
    found, times = joined(results, changes, since, told), saved["t"]
    found.outcome, found.site, found._until = outcome, saved.get("site", ""), tuple(saved["until"])
    for name in FACTS:
        setattr(found, name, saved[name])
    if len(times) < len(found.t):
        last = times[-1] if outcome is Outcome.INACCURATE else np.inf
        keep(found, np.isin(found.t, times), since, last)
    return found

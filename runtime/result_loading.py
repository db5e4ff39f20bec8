"""Results from files: the `Result` that was saved, with its machine.

A file executes nothing, and names no file that is executed: its machine is the one that is given,
or one that this process has loaded.
"""

import os
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen.errors import FAILURES, InputError, LinkwrightError
from codegen.files.generated_modules import content_hash
from codegen.readers import arguments as readers
from codegen.readers.values import KindError, one_line
from runtime.results.saved_result import (
    GROUP,
    KINDS,
    events_of,
    floats,
    partitions_of,
    samples_of,
    unpack,
)

if TYPE_CHECKING:
    from runtime.integrate.problem import Discrete
    from runtime.machine_facade import Machine
    from runtime.mechanism.dense_equations import FloatArray
    from runtime.mechanism.mechanism import Mechanism
    from runtime.results.assembled_state import Assembly
    from runtime.results.motion_at_instants import Motion
    from runtime.results.result import Result

_LIBRARIES = {".nc": "netCDF4", ".zarr": "zarr"}


def _machine(value: Any) -> Any:
    from runtime.machine_facade import Machine

    if not isinstance(value, Machine):
        raise KindError("it must be a machine, as load() makes it.")
    return value


@readers.reads(path=readers.path, machine=readers.optional(_machine))
def load_result(path: str | os.PathLike[str], machine: "Machine | None" = None) -> "Result":
    """The result that `Result.save` wrote into a .nc file or a .zarr store, with all that it had.

    The machine computes its quantities again from its states, with the same bits. `Result.at` and
    `Result.resume` take the run again from its start, since no checkpoint stands in a file: they
    return the same bits, after as long as the run took. Functions of your own that control a run,
    which no file keeps, are missing there: simulate anew. That of an equilibrium comes back as a
    plain result.

    Parameters
    ----------
    path
        A file ending in .nc or a store ending in .zarr, in any folder.
    machine
        The machine of the result; unless given, that of its model and scene which is loaded. That
        of an equilibrium, whose file does not tell the text of its model, must be given.

    Raises
    ------
    InputError
        If the file cannot be read or was not written by `Result.save`, if the model is another
        one than it was, or if `machine` is not given and none of the result's scene is loaded.
    """
    place = Path(path)
    saved = _content(place)
    mechanism = _mechanism_of(place, saved, None if machine is None else machine.mechanism)
    try:
        return _result(mechanism, saved)
    except LinkwrightError:
        raise
    except FAILURES as error:
        raise _unreadable(place, error) from error


def _content(path: Path) -> dict[str, Any]:
    """What `Result.save` wrote beside the series."""
    from runtime.integrate.problem import Discrete

    ending = path.suffix.lower()
    if ending not in _LIBRARIES:
        raise InputError(
            f"{path}: results come back from .nc files and .zarr stores alone, as Result.save "
            "writes them."
        )
    if not path.exists():
        raise InputError(f"{path}: there is no such file.")
    try:
        import_module(_LIBRARIES[ending])
    except ImportError as error:
        raise InputError(
            f"{path}: reading {path.suffix} needs the library {_LIBRARIES[ending]}, which cannot "
            f"be imported ({error}). Run pip install 'linkwright[files]', in the checkout pip "
            "install '.[files]'."
        ) from error
    try:
        content = _read_netcdf(path) if ending == ".nc" else _read_zarr(path)
        saved: dict[str, Any] = unpack(content, [*KINDS, Discrete])
        _ = saved["title"].partition, _source(saved)
    except InputError:
        raise
    except FAILURES as error:
        raise _unreadable(path, error) from error
    return saved


def _read_netcdf(path: Path) -> bytes:
    import netCDF4

    with netCDF4.Dataset(path) as file:
        return np.asarray(file.groups[GROUP].variables[GROUP][:], np.uint8).tobytes()


def _read_zarr(path: Path) -> bytes:
    from runtime.results.zarr_store import read_content

    return read_content(path)


def _unreadable(path: Path, error: BaseException) -> InputError:
    return InputError(
        f"{path} was not written by this version of Result.save, or is damaged "
        f"({type(error).__name__}). Read the numbers alone with xarray."
    )


def _source(saved: dict[str, Any]) -> dict[str, str] | None:
    """Where the machine of a saved result comes from; KeyError where a field is missing."""
    source = saved["motion"] and saved["motion"]["source"]
    return source and {name: source[name] for name in ("model", "scene", "content")}


def _mechanism_of(path: Path, saved: dict[str, Any], given: "Mechanism | None") -> "Mechanism":
    """The mechanism of a result: of the machine that is given, or of one that is loaded."""
    from runtime.machine_loading import LOADED
    from runtime.mechanism.sibling_scenes import sibling_named

    title, source = saved["title"], _source(saved)
    model, _, scene = title.partition("/")
    known = [*LOADED] if given is None else [given]
    near = [one for one in known if one.description.model == model]
    found = [one for one in (sibling_named(one, scene) for one in near) if one is not None]
    if given is not None and not found:
        raise InputError(
            f"{path} has a result of {title}, and the machine is {given.description.title}."
        )
    if not found:
        file = one_line(source["model"]) if source and source["model"] else "the model"
        raise InputError(
            f"{path} has a result of {one_line(title)}, whose machine is not loaded. Load it "
            f"({file}, scene {one_line(scene)}) and give it: load_result(path, "
            "machine=load(...)); or read the numbers alone with xarray."
        )
    if given is None and source is None:  # nothing tells whether a loaded machine is that one
        raise InputError(
            f"{path} does not say from which text the machine of {one_line(title)} came, as that "
            "of an equilibrium does not. Give it: load_result(path, machine=load(...))."
        )
    for one in found:
        origin = one.origin
        if source is None or origin is None:
            return one
        if source["content"] == content_hash(origin.path, origin.digest):
            return one
    raise InputError(
        f"{path}: the model of {title}, or the generator, has changed since the result was saved, "
        f"so that {found[-1].path} computes something else. Load the machine as it was, and give "
        "it as machine=; or read the numbers alone with xarray."
    )


def _result(mechanism: "Mechanism", saved: dict[str, Any]) -> "Result":
    """The result of a machine that was saved."""
    from runtime.assembly.assemble import assemble
    from runtime.core.outcomes import Outcome
    from runtime.dynamics.output_quantities import evaluate
    from runtime.mechanism.dense_equations import Equations
    from runtime.results.assembled_state import State
    from runtime.results.result import Result
    from runtime.validation.parameters import parameter_values

    kept, parameters = saved["motion"], saved["parameters"]
    if kept is not None and "parts" in kept:
        return _joined(mechanism, saved)
    p, motion, variant = parameter_values(mechanism, parameters), None, mechanism
    states = samples_of(saved["samples"], mechanism.description)
    if kept is not None:
        q, v = (floats(kept[name], states[name].shape[1:], name) for name in "qv")
        state = State(kept["t"], q, v)
        start = assemble(Equations(mechanism, p), state.t, start_at=state)
        start = replace(start, q=q, v=v)
        make = _simulated if saved["analysis"] == "simulation" else _driven
        variant, motion = make(mechanism, start, saved)
    samples = evaluate(Equations(variant, p), **states)
    result = Result(
        mechanism.description, samples, p, analysis=saved["analysis"],
        outcome=Outcome[saved["outcome"]], message=saved["message"], stats=saved["stats"],
        events=events_of(saved["events"]), partitions=partitions_of(saved["partitions"]),
        not_unique=saved["not_unique"], singular=saved["singular"],
    )  # fmt: skip
    result.works, result.accuracy = saved["works"], saved["accuracy"]
    result.contradiction, result._motion = saved["contradiction"], motion
    result._mechanism = mechanism
    result.ended_by, result.work_at_end = saved["ended_by"], saved["work_at_end"]
    result.site = saved.get("site", "")  # of older files unknown
    result._until = tuple(saved["until"])
    return result


def _joined(mechanism: "Mechanism", saved: dict[str, Any]) -> "Result":
    """The result of several runs, with other joints each."""
    from runtime.core.outcomes import Outcome
    from runtime.dynamics.connected_simulation import joined
    from runtime.mechanism.sibling_scenes import sibling
    from runtime.results.motion_at_instants import keep

    results, changes = [], saved["motion"]["changes"]
    for part, change in zip(saved["motion"]["parts"], [None, *changes], strict=True):
        if change is not None:
            watched = next(
                row
                for row in mechanism.description.watched
                if (row.target, row.action) == (change.joint, change.action)
            )
            mechanism = sibling(mechanism, watched)
        results.append(_result(mechanism, part))
    found, times = joined(results, changes, saved["motion"]["since"]), saved["t"]
    found.outcome, found.message = Outcome[saved["outcome"]], saved["message"]
    if len(times) < len(found.t):
        last = times[-1] if found.outcome is Outcome.INACCURATE else np.inf
        keep(found, np.isin(found.t, times), saved["motion"]["since"], last)
    found.accuracy, found.ended_by = saved["accuracy"], saved["ended_by"]
    found.site = saved.get("site", "")
    found._until = tuple(saved["until"])
    return found


def _simulated(
    mechanism: "Mechanism", start: "Assembly", saved: dict[str, Any]
) -> "tuple[Mechanism, Motion]":
    """The run of a simulation, and the mechanism with the kernels that it took."""
    from runtime.dynamics.formulations import formulate
    from runtime.dynamics.motion_at_instants import SimulatedMotion
    from runtime.dynamics.prepared_simulation import PreparedSimulation
    from runtime.integrate.checkpoints import Checkpoints
    from runtime.integrate.problem import Options
    from runtime.validation.parameters import parameter_values

    def missing(*_: Any) -> float:
        raise InputError(
            f"{mechanism.title}: the controllers of this run are functions that no file keeps, so "
            "it cannot be taken again. Simulate anew."
        )

    kept, p = saved["motion"], parameter_values(mechanism, saved["parameters"])
    length = kept["length"]
    ready = PreparedSimulation(
        mechanism, kept["t_end"], t_start=start.t, parameters=saved["parameters"], guess=None,
        start=start, controllers=dict.fromkeys(mechanism.description.controllers, missing),
        length=length if length is None else float(length),
    )  # fmt: skip
    ready.given_t = kept["given_t"]
    ready.samples_taken, taken = kept["taken"]
    ready.discrete, last = (_discrete(mechanism, p, stand) for stand in kept["discrete"])
    options = Options(**kept["options"])
    coordinates = formulate(ready, kept["formulation"], options.method, options.correction)
    motion = SimulatedMotion(coordinates, options, Checkpoints(), kept["end"], taken, last)
    return coordinates.equations.mechanism, motion


def _discrete(mechanism: "Mechanism", p: "FloatArray", stand: Any) -> "Discrete | None":
    """Where clocks and conditions stand, by the tables of the machine; InputError if by others."""
    from runtime.integrate.clocks import queue_length, read_clocks
    from runtime.integrate.problem import Discrete

    if stand is None:
        return None
    clocks = read_clocks(mechanism.system, p)
    count, queue = len(clocks), queue_length(clocks)
    ticks = floats(stand.ticks, (2 * count,), "ticks").astype(np.int64)
    ahead = np.diff(ticks.reshape(count, 2))  # from the next sample to the next that acts
    if ((ahead > 0) | (ahead < -queue)).any():
        raise InputError("the array ticks of the file has clocks that wait for what never comes.")
    waiting = floats(stand.waiting, (count, queue), "waiting")
    watched = len(mechanism.description.watched)
    return Discrete(ticks, waiting, floats(stand.held, (watched,), "held"))


def _driven(
    mechanism: "Mechanism", start: "Assembly", saved: dict[str, Any]
) -> "tuple[Mechanism, Motion]":
    """The motion that drivers prescribe, and the mechanism with the kernels that it took."""
    from runtime.assembly.substitute_kernels import suited_equations
    from runtime.dynamics.prescribed_motion import DrivenMotionAtInstants
    from runtime.mechanism.dense_equations import Equations
    from runtime.validation.parameters import parameter_values

    kept, p = saved["motion"], parameter_values(mechanism, saved["parameters"])
    suited = suited_equations(Equations(mechanism, p), start).mechanism
    preferred: FloatArray = floats(kept["preferred"], start.q.shape, "preferred")
    times = floats(kept["times"], (-1,), "times")
    return suited, DrivenMotionAtInstants(suited, p, start, preferred, times)

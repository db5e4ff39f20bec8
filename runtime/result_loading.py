"""Results from files: the `Result` that was saved, with its machine."""

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from codegen import argument_readers as readers
from codegen.errors import FAILURES, InputError
from codegen.generated_module_signature_and_import import content_hash
from codegen.plain_values import KindError
from runtime.results.saved_result import GROUP, KINDS, events_of, partitions_of

if TYPE_CHECKING:
    from runtime.machine_facade import Machine
    from runtime.mechanism.dense_equations import FloatArray
    from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
    from runtime.results.assembled_state import Assembly
    from runtime.results.motion_at_instants import Motion
    from runtime.results.result import Result
    from runtime.results.samples import Samples


def _machine(value: Any) -> Any:
    from runtime.machine_facade import Machine

    if not isinstance(value, Machine):
        raise KindError("it must be a machine, as load() makes it.")
    return value


@readers.reads(path=readers.path, machine=readers.optional(_machine))
def load_result(path: str | os.PathLike[str], machine: "Machine | None" = None) -> "Result":
    """The result that `Result.save` wrote into a .nc file, with all that it had.

    Its quantities are computed again from its states by the machine, with the same bits, so that
    `Result.at` and `Result.resume` go on as well: functions of your own that control a run, which
    no file keeps, are missing there. That of an equilibrium comes back as a plain result.

    Parameters
    ----------
    path
        A file ending in .nc, in any folder.
    machine
        The machine of the result, loaded from anywhere; unless given, that of the model file from
        which it was loaded, whose place the file tells.

    Raises
    ------
    InputError
        If the file cannot be read or was not written by `Result.save`, or if the model is another
        one than it was.
    """
    from runtime.mechanism.sibling_scenes import sibling_named

    place = Path(path)
    saved = _content(place)
    machine = machine or _machine_of(place, saved)
    mechanism, title = machine.mechanism, saved["title"]
    mechanism = sibling_named(mechanism, title.partition("/")[2]) or mechanism
    if mechanism.description.title != title:
        raise InputError(
            f"{place} has a result of {title}, and the machine is {mechanism.description.title}."
        )
    source, origin = _source(saved), mechanism.origin
    content = None if origin is None else content_hash(origin.path, origin.digest)
    if source and origin is not None and source["content"] != content:
        raise InputError(
            f"{place}: the model of {title}, or the generator, has changed since the result was "
            f"saved, so that {origin.path} computes something else. Load the machine as it was, "
            "and give it as machine=; or read the numbers alone with xarray.open_dataset."
        )
    try:
        return _result(mechanism, saved)
    except KeyError as error:
        raise _unreadable(place, error) from error


def _content(path: Path) -> dict[str, Any]:
    """What `Result.save` wrote beside the series."""
    from runtime.dynamics.changes_of_coordinates import RunsSnapshot
    from runtime.dynamics.prepared_simulation import Handover
    from runtime.integrate.checkpoints import Checkpoint, Snapshot
    from runtime.integrate.problem import Discrete
    from runtime.integrate.trajectory import Crossing
    from runtime.results.packed_values import unpack

    if path.suffix != ".nc":
        raise InputError(f"{path}: results come back from .nc files alone, as Result.save writes.")
    if not path.is_file():
        raise InputError(f"{path}: there is no such file.")
    try:
        import netCDF4
    except ImportError as error:
        raise InputError(
            f"{path}: reading .nc needs the library netCDF4, which cannot be imported ({error}). "
            "Run pip install 'linkwright[files]', in the checkout pip install '.[files]'."
        ) from error
    kinds = [*KINDS, Checkpoint, Crossing, Discrete, Handover, RunsSnapshot, Snapshot]
    try:
        with netCDF4.Dataset(path) as file:
            content = np.asarray(file.groups[GROUP].variables[GROUP][:], np.uint8).tobytes()
        saved: dict[str, Any] = unpack(content, kinds)
        _ = saved["title"], _source(saved)
    except (*FAILURES, KeyError, OSError) as error:
        raise _unreadable(path, error) from error
    return saved


def _unreadable(path: Path, error: BaseException) -> InputError:
    return InputError(
        f"{path} was not written by this version of Result.save, or is damaged "
        f"({type(error).__name__}). Read the numbers alone with xarray.open_dataset."
    )


def _source(saved: dict[str, Any]) -> dict[str, str] | None:
    """Where the machine of a saved result comes from; KeyError where a field is missing."""
    source = saved["motion"] and saved["motion"]["source"]
    return source and {name: source[name] for name in ("model", "scene", "generated", "content")}


def _machine_of(path: Path, saved: dict[str, Any]) -> "Machine":
    """The machine of a saved result, from its model file."""
    from runtime.machine_loading import load

    source = _source(saved)
    if not source or not source["model"]:
        raise InputError(
            f"{path}: the machine of {saved['title']} was not loaded from a model file. Give it: "
            "load_result(path, machine=...)."
        )
    folder = source["generated"] if Path(source["generated"]).is_dir() else None
    return load(source["model"], source["scene"], generated=folder)


def _result(mechanism: "Mechanism", saved: dict[str, Any]) -> "Result":
    """The result of a machine that was saved."""
    from runtime.assembly.assemble import assemble
    from runtime.core.outcomes import Outcome
    from runtime.results.assembled_state import State
    from runtime.results.result import Result
    from runtime.validation.parameters import parameter_values

    kept, parameters = saved["motion"], saved["parameters"]
    if kept is not None and "parts" in kept:
        return _joined(mechanism, saved)
    p, motion, variant = parameter_values(mechanism, parameters), None, mechanism
    if kept is not None:
        state = State(kept["t"], kept["q"], kept["v"])
        start = assemble(mechanism, None, parameters, state.t, start_at=state)
        start = replace(start, q=kept["q"], v=kept["v"])
        make = _simulated if saved["analysis"] == "simulation" else _driven
        variant, motion = make(mechanism, start, saved)
    samples = _samples(variant, p, saved["samples"])
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
    result._until = tuple(saved["until"])
    return result


def _joined(mechanism: "Mechanism", saved: dict[str, Any]) -> "Result":
    """The result of several runs, with other joints each."""
    from runtime.core.outcomes import Outcome
    from runtime.dynamics.joined_results import joined
    from runtime.mechanism.sibling_scenes import sibling
    from runtime.results.kept_instants import keep

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
    found._until = tuple(saved["until"])
    return found


def _samples(mechanism: "Mechanism", p: "FloatArray", kept: dict[str, Any]) -> "Samples":
    from runtime.dynamics.output_quantities import evaluate

    return evaluate(mechanism, p, kept["t"], kept["q"], kept["v"], kept["modes"])


def _simulated(
    mechanism: "Mechanism", start: "Assembly", saved: dict[str, Any]
) -> "tuple[Mechanism, Motion]":
    """The run of a simulation, and the mechanism with the kernels that it took."""
    from runtime.dynamics.formulations import formulate
    from runtime.dynamics.motion_at_instants import SimulatedMotion
    from runtime.dynamics.prepared_simulation import PreparedSimulation
    from runtime.integrate.checkpoints import Checkpoints
    from runtime.integrate.problem import Options

    def missing(*_: Any) -> float:
        raise InputError(
            f"{mechanism.title}: the controllers of this run are functions that no file keeps, so "
            "it cannot be taken again. Simulate anew."
        )

    kept = saved["motion"]
    ready = PreparedSimulation(
        mechanism, kept["t_end"], t_start=start.t, parameters=saved["parameters"], guess=None,
        start=start, controllers=dict.fromkeys(mechanism.description.controllers, missing),
        handover=kept["handover"],
    )  # fmt: skip
    ready.given_t = kept["given_t"]
    ready.samples_taken, taken = kept["taken"]
    ready.discrete, last = kept["discrete"]
    options = Options(**kept["options"])
    coordinates = formulate(ready, kept["formulation"], options.method, options.correction)
    checkpoints = Checkpoints(rows=kept["checkpoints"])
    motion = SimulatedMotion(ready, coordinates, options, checkpoints, kept["end"], taken, last)
    return coordinates.mechanism, motion


def _driven(
    mechanism: "Mechanism", start: "Assembly", saved: dict[str, Any]
) -> "tuple[Mechanism, Motion]":
    """The motion that drivers prescribe, and the mechanism with the kernels that it took."""
    from runtime.assembly.kernels_for_redundant_constraints import with_redundancy
    from runtime.assembly.masses_far_apart import suited_to_masses
    from runtime.dynamics.motion_at_instants import DrivenMotionAtInstants
    from runtime.validation.parameters import parameter_values

    kept, p = saved["motion"], parameter_values(mechanism, saved["parameters"])
    suited = suited_to_masses(with_redundancy(mechanism, start), start.t, start.q, p)
    return suited, DrivenMotionAtInstants(suited, p, start, kept["preferred"], kept["times"])

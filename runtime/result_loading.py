"""Results from files: the `Result` that was saved, with its machine.

A file from elsewhere executes nothing: the model file that it names is loaded, and its checkpoints
are handed to compiled code, only where this user saved it; see `runtime.results.result_signature`.
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
from codegen.readers.values import KindError
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
    """The result that `Result.save` wrote into a .nc file or a .zarr store, with all that it had.

    Its quantities are computed again from its states by the machine, with the same bits, so that
    `Result.at` and `Result.resume` go on as well: functions of your own that control a run, which
    no file keeps, are missing there. That of an equilibrium comes back as a plain result.

    Parameters
    ----------
    path
        A file ending in .nc or a store ending in .zarr, in any folder.
    machine
        The machine of the result, loaded from anywhere; unless given, that of the model file from
        which it was loaded, whose place the file tells. A model file is Python and is executed, so
        that a file which was not saved by you, on this machine, needs this argument.

    Raises
    ------
    InputError
        If the file cannot be read or was not written by `Result.save`, if the model is another
        one than it was, or if somebody else saved it and `machine` is not given.
    """
    from runtime.mechanism.sibling_scenes import sibling_named
    from runtime.results.result_signature import key_problem

    place = Path(path)
    saved, own = _content(place)
    if machine is None and not own:
        why = key_problem()
        whose = f"may be your own, but {why}" if why else "was not saved by you on this machine"
        raise InputError(
            f"{place} {whose}, and the model file that it names is Python, which would be "
            f"executed. Load the machine of {saved['title']} from a model file that you trust: "
            "load_result(path, machine=load(...)); or read the numbers alone with xarray."
        )
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
            "and give it as machine=; or read the numbers alone with xarray."
        )
    try:
        return _result(mechanism, saved, own)
    except LinkwrightError:
        raise
    except KeyError as error:
        raise _unreadable(place, error) from error
    except FAILURES as error:
        if own:
            raise
        raise _unreadable(place, error) from error


def _content(path: Path) -> tuple[dict[str, Any], bool]:
    """What `Result.save` wrote beside the series, and whether this user did."""
    from runtime.dynamics.changes_of_coordinates import RunsSnapshot
    from runtime.dynamics.prepared_simulation import Handover
    from runtime.integrate.checkpoints import Checkpoint, Snapshot
    from runtime.integrate.problem import Discrete
    from runtime.integrate.trajectory import Crossing
    from runtime.results.packed_values import unpack
    from runtime.results.result_signature import is_own

    libraries = {".nc": "netCDF4", ".zarr": "zarr"}
    if path.suffix.lower() not in libraries:
        raise InputError(
            f"{path}: results come back from .nc files and .zarr stores alone, as Result.save "
            "writes them."
        )
    if not path.exists():
        raise InputError(f"{path}: there is no such file.")
    library = libraries[path.suffix.lower()]
    try:
        import_module(library)
    except ImportError as error:
        raise InputError(
            f"{path}: reading {path.suffix} needs the library {library}, which cannot be imported "
            f"({error}). Run pip install 'linkwright[files]', in the checkout pip install "
            "'.[files]'."
        ) from error
    kinds = [*KINDS, Checkpoint, Crossing, Discrete, Handover, RunsSnapshot, Snapshot]
    try:
        content, signed = _read_zarr(path) if library == "zarr" else _read_netcdf(path)
        saved: dict[str, Any] = unpack(content, kinds)
        _ = saved["title"], _source(saved)
    except InputError:
        raise
    except (*FAILURES, KeyError, OSError) as error:
        raise _unreadable(path, error) from error
    return saved, is_own(content, signed)


def _read_netcdf(path: Path) -> tuple[bytes, str]:
    import netCDF4

    with netCDF4.Dataset(path) as file:
        group = file.groups[GROUP]
        content = np.asarray(group.variables[GROUP][:], np.uint8).tobytes()
        return content, str(getattr(group, "signature", ""))


def _read_zarr(path: Path) -> tuple[bytes, str]:
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


def _result(mechanism: "Mechanism", saved: dict[str, Any], own: bool) -> "Result":
    """The result of a machine that was saved."""
    from runtime.assembly.assemble import assemble
    from runtime.core.outcomes import Outcome
    from runtime.results.assembled_state import State
    from runtime.results.result import Result
    from runtime.results.saved_arrays import plain_arrays
    from runtime.validation.parameters import parameter_values

    if saved["motion"] is not None and "parts" in saved["motion"]:
        return _joined(mechanism, saved, own)
    saved = saved if own else plain_arrays(saved, mechanism.description)
    kept, parameters = saved["motion"], saved["parameters"]
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


def _joined(mechanism: "Mechanism", saved: dict[str, Any], own: bool) -> "Result":
    """The result of several runs, with other joints each."""
    from runtime.core.outcomes import Outcome
    from runtime.dynamics.joined_results import joined
    from runtime.mechanism.sibling_scenes import sibling
    from runtime.results.result_restriction import keep

    results, changes = [], saved["motion"]["changes"]
    for part, change in zip(saved["motion"]["parts"], [None, *changes], strict=True):
        if change is not None:
            watched = next(
                row
                for row in mechanism.description.watched
                if (row.target, row.action) == (change.joint, change.action)
            )
            mechanism = sibling(mechanism, watched)
        results.append(_result(mechanism, part, own))
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

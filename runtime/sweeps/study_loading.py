"""A study that a sweep wrote, read in any process: data, and nothing that is run."""

import os
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

from codegen.errors import InputError
from codegen.readers import arguments as readers
from codegen.readers.values import KindError
from runtime.sweeps.block import companions_of
from runtime.sweeps.programs import changed_programs
from runtime.sweeps.request import request_of
from runtime.sweeps.study import Study

if TYPE_CHECKING:
    from runtime.machine_facade import Machine


def _study_path(value: Any) -> Path:
    path: Path = readers.path(value)
    if not path.is_dir():
        raise KindError("there is no such folder; name the one that a sweep has written.")
    return path


def _machine(value: Any) -> Any:
    from runtime.machine_facade import Machine

    if not isinstance(value, Machine):
        raise KindError("it must be a machine, as load() makes it.")
    return value


@readers.reads(path=_study_path, machine=readers.optional(_machine))
def load_study(path: str | os.PathLike[str], machine: "Machine | None" = None) -> Study:
    """The study that a sweep wrote, in any process.

    It is data alone: nothing of it is run, and no model is loaded because a file names it.

    Parameters
    ----------
    path
        The folder of the Zarr store.
    machine
        The machine of the study, for `Study.member`. A warning says where the programs are others
        than those of the sweep, so that the last digits of a run may differ.

    Raises
    ------
    InputError
        If it was not written by a sweep, has anything but a sweep's data, or is that of another
        machine.
    """
    place = Path(path).resolve()
    study = Study(place)
    if machine is None:
        return study
    facts = study.facts()["facts"]
    origin = machine.mechanism.origin
    if origin is None or origin.digest != facts["generated module"]:
        raise InputError(
            f"{place} is a study of {facts['model']} whose generated module had another text than "
            f"that of {machine.mechanism.title}: the model has changed since, or is another one."
        )
    request = request_of(facts, study.factors)
    changes = [*changed_programs(facts)]
    if companions_of(machine, request.companions) != request.companions:
        changes.append("the derivatives or reduced equations have another text")
    if changes:
        warnings.warn(
            f"Runs of {place} that are made again may differ in their last digits: "
            f"{'; '.join(changes)}.",
            stacklevel=2,
        )
    return Study(place, machine, request)

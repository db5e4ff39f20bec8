"""Linkwright's runtime: loads a generated module and answers the engineer's four questions with it.

    from runtime import load

    machine = load("slider_crank", scene="compressor")
    result = machine.simulate(t_end=1.0)

Importing this package loads neither numba nor the code generator; `load` does what it needs.
"""

TYPE_CHECKING = False  # type checkers take it as true; importing typing would load modules
if TYPE_CHECKING:
    from runtime.cases.case import Case, load_case
    from runtime.core.outcomes import Outcome
    from runtime.machine_facade import Machine
    from runtime.machine_loading import load
    from runtime.result_loading import load_result
    from runtime.results.assembled_state import Assembly
    from runtime.results.result import Result
    from runtime.results.run_records import Event
    from runtime.show.animation.animation import Animation, animate
    from runtime.statics.equilibrium import Equilibrium
    from runtime.studies.effect_ranking import matters
    from runtime.studies.work_precision import accuracy
    from runtime.sweeps.study import Study, load_study
    from runtime.sweeps.sweep import sweep

_HOMES = {
    "Animation": "runtime.show.animation.animation",
    "Assembly": "runtime.results.assembled_state",
    "Case": "runtime.cases.case",
    "Equilibrium": "runtime.statics.equilibrium",
    "Event": "runtime.results.run_records",
    "Machine": "runtime.machine_facade",
    "Outcome": "runtime.core.outcomes",
    "Result": "runtime.results.result",
    "Study": "runtime.sweeps.study",
    "accuracy": "runtime.studies.work_precision",
    "animate": "runtime.show.animation.animation",
    "load": "runtime.machine_loading",
    "load_case": "runtime.cases.case",
    "load_result": "runtime.result_loading",
    "load_study": "runtime.sweeps.study",
    "matters": "runtime.studies.effect_ranking",
    "sweep": "runtime.sweeps.sweep",
}

__all__ = ["Animation", "Assembly", "Case", "Equilibrium", "Event", "Machine", "Outcome", "Result"]
__all__ += ["Study", "accuracy", "animate", "load", "load_case", "load_result", "load_study"]
__all__ += ["matters", "sweep"]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'runtime' has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value

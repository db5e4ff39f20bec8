"""The scene in which a run begins: of a machine whose joints come and go, that of its state."""

from runtime.mechanism.mechanism_tables_and_kernels import Mechanism, Values
from runtime.mechanism.sibling_scenes import sibling_named
from runtime.results.assembled_state import State
from runtime.results.result import Result


def scene_of_start(mechanism: Mechanism, start: object) -> Mechanism:
    """The mechanism with the joints that act in the state `start`, where these come and go.

    A state of any other scene, and values by name, leave the mechanism as it is.
    """
    state = start.state() if isinstance(start, Result) else start
    scene = state.scene if isinstance(state, State) else ""
    return sibling_named(mechanism, scene) or mechanism


def parameters_there(
    there: Mechanism, mechanism: Mechanism, parameters: Values | None
) -> Values | None:
    """Values of the parameters of `mechanism`, without those that only its other scenes need.

    `there` is the mechanism of the scene in which a run begins.
    """
    rows = there.description.watched
    if not parameters or there is mechanism or any(row.reconnects for row in rows):
        return parameters
    idle = {*there.description.unused} - {*mechanism.description.unused}
    return {name: value for name, value in parameters.items() if name not in idle}

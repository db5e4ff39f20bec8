"""The scene in which a run begins: of a machine whose joints come and go, that of its state."""

from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.mechanism.sibling_scenes import sibling
from runtime.results.assembled_state import State
from runtime.results.result import Result


def scene_of_start(mechanism: Mechanism, start: object) -> Mechanism:
    """The mechanism with the joints that act in the state `start`, where these come and go.

    A state of any other scene, and values by name, leave the mechanism as it is.
    """
    state = start.state() if isinstance(start, Result) else start
    wanted = state.scene if isinstance(state, State) else ""
    found, passed = mechanism, {""}
    while found.description.scene not in {wanted, *passed}:
        scene = found.description.scene
        passed.add(scene)
        ways = [row for row in found.description.watched if row.reconnects]
        direct = [row for row in ways if row.scene == wanted]
        # A sibling is named after the joints in which it differs from the first one.
        apart = [row for row in ways if (f"_{row.target}" in wanted) != (f"_{row.target}" in scene)]
        if nearer := [row for row in direct + apart if row.scene not in passed]:
            found = sibling(found, nearer[0])
    return found if found.description.scene == wanted else mechanism

"""Outputs that a scene does not name, computed from the states of a result when they are asked for.

The scene's companion module with all outputs evaluates the stored states, each with its modes, on
its side of an event, and with the joints that act there. Works are integrals along the steps of a
run, and no functions of states.
"""

import numpy as np

from codegen.errors import InputError
from runtime.assembly.redundancy import suited_equations
from runtime.dynamics.connected_simulation import known_parameters
from runtime.dynamics.motion_at_instants import start_again
from runtime.dynamics.output_quantities import evaluate
from runtime.mechanism.dense_equations import Equations
from runtime.mechanism.module_tables import Description
from runtime.results.result import Result
from runtime.results.samples import Samples
from runtime.show.pictures import spans_of
from runtime.validation.arguments import parameter_values


def outputs_afterwards(result: Result) -> list[tuple[slice, Description, Samples]]:
    """Rows of the result, and all outputs in them with their tables: a part a set of joints."""
    mechanism, there = result._mechanism, result.description
    if mechanism is None:
        raise InputError(f"{there.title}: the machine of this result is not known; load it.")
    found, times, parts = [], result.instants_of_states, spans_of(result, mechanism)
    acting = {known.description.scene for known, _ in parts}
    others = [one for scene, one in mechanism.siblings.items() if scene not in acting]
    for known, rows in [*parts, *((one, slice(0)) for one in others)]:
        whole = known.with_all_outputs
        here, states = whole.description, result.samples.at(rows)
        places = {name: k for k, name in enumerate(there.coordinates.names)}
        columns = [places[name] for name in here.coordinates.names]
        q, v = (np.ascontiguousarray(x[:, columns]) for x in (states.q, states.v))
        switches = {row: k for k, row in enumerate(there.switches)}
        modes = states.modes[:, [switches[row] for row in here.switches]]
        p = parameter_values(whole, known_parameters(whole, result.parameters))
        equations = Equations(whole, p)
        if len(q) and np.isfinite(v[0]).all():  # else it is locked, and nothing is a number
            begin = start_again(whole, p, float(times[rows][0]), q[0], v[0])
            equations = suited_equations(equations, begin)
        found.append((rows, here, evaluate(equations, times[rows], q, v, modes)))
    return found

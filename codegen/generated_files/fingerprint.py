"""A hash of what was declared: equal exactly when a scene's equations, numbers and names are."""

import hashlib

from codegen.derive.equations import Equations


def fingerprint(equations: Equations) -> str:
    """SHA-256 of a scene's declaration, whatever the order in which sets were walked."""
    lines = [f"{equations.model} {equations.scene!r} {equations.coordinates}"]
    lines += [f"parameter {p!r}" for p in equations.parameters]
    lines += [f"mass {m}" if i == k else f"mass {i} {k} {m}" for i, k, m in equations.mass]
    lines += [f"inertia force {k} {f}" for k, f in equations.inertia_force]
    for constraint in equations.constraints:
        statement = constraint.statement
        bindings = sorted(f"{place}={meaning}" for place, meaning in statement.bindings.items())
        lines.append(f"{constraint.kind} {constraint.name} {statement.phi} {bindings}")
        lines += [f"  own {row} {q}" for row, q in statement.own]
        lines.append(f"  reactions {constraint.terms.reactions}")
    for effect in equations.effects:
        terms = effect.terms
        lines.append(f"{effect.kind} {effect.name} {terms.potential} {terms.loads}")
        lines += [f"  pulls {terms.pulls}"] if terms.pulls else []
        lines += [f"  friction {terms.friction}"] if terms.friction else []
        lines += [f"  hold {terms.hold}"] if terms.hold else []
        lines += [f"  reported {terms.reported}"] if terms.reported else []
    lines += [f"switch {switch.g}" for switch in equations.switches]
    lines.append(f"left out {equations.left_out}")
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()

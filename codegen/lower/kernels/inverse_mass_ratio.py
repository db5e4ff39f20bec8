"""How far apart the masses of a scene lie, as its constraints feel them.

A constraint with the row b of Φ_q feels the coordinate k with the mobility b_k² / M_kk: a light
body, a small moment of inertia at a long arm, answer to it most. Where one row feels mobilities
that lie far apart, an elimination that begins with M⁻¹ loses as many digits as the ratio has, and
pivots of Φ_q M⁻¹ Φ_qᵀ say nothing of rank.
"""

import math

from codegen.declare.symbols import Parameter
from codegen.derive.inertia import neutral
from codegen.errors import ModelError
from codegen.lower.constant_hoisting import WEAK_PIVOT
from codegen.lower.interpreter import evaluate
from codegen.lower.program import Kernel, Output, Program
from codegen.lower.scene_graph import SceneGraph

FAR = 1e5
"""accuracy: ratio of mobilities, of masses, or of moments of inertia, from which on solutions are
refined: an elimination that divides by the wrong ones loses as many digits as the ratio has.
"""
_NEGLIGIBLE = 1e-6  # accuracy: a slope of a length, or an arm beside the longest, that is none
_POSES = 5  # safety: poses in which arms are looked at; one in which all of them vanish is rare


def inverse_mass_ratio(scene: SceneGraph) -> float:
    """Largest ratio of two mobilities in a row of Φ_q, of two masses, or of two inertias.

    With the parameters as declared, at lengths of 0 and several angles. Raises ModelError where no
    float holds it.
    """
    inertia = _inertias(scene)
    if not inertia:
        return 1.0
    coordinates = scene.equations.coordinates
    groups: dict[str, list[float]] = {}
    for k, size in inertia.items():
        groups.setdefault(coordinates[k].unit, []).append(size)
    lengths = {k for k, q in enumerate(coordinates) if q.unit == "m"}
    ratios = [max(group) / min(group) for group in groups.values()]
    for i, row in _felt_slopes(scene, lengths).items():
        try:
            felt = [s**2 / inertia[k] for k, s in row.items() if k in inertia]
            ratios.append(max(felt) / min(felt) if felt else 1.0)
        except ArithmeticError:  # beyond the largest float, or nearer to 0 than the smallest
            ratios.append(math.inf)
        if not math.isfinite(ratios[-1]):
            raise ModelError(
                f"joint or driver '{scene.rows[i]}': masses and moments of inertia at its arms, "
                f"from {min(row.values()):.3g} to {max(row.values()):.3g} m, lie more than 1e308 "
                "times apart; give kg, kg m^2 and m of one machine."
            )
    return max(ratios)


def _felt_slopes(scene: SceneGraph, lengths: set[int]) -> dict[int, dict[int, float]]:
    """Row by row the largest |Φ_ik| of all poses, beside those of lengths, without rounding."""
    found: dict[int, dict[int, float]] = {}
    for entries in map(_Slopes(scene).at, range(_POSES)):
        for (i, k), slope in entries.items():
            if math.isfinite(slope) and slope != 0.0:
                row = found.setdefault(i, {})
                row[k] = max(row.get(k, 0.0), abs(slope))
    for i, row in found.items():
        unit = max((s for k, s in row.items() if k in lengths), default=max(row.values()))
        found[i] = {k: s / unit for k, s in row.items()}
    of_angles = (s for row in found.values() for k, s in row.items() if k not in lengths)
    least = dict.fromkeys(lengths, _NEGLIGIBLE)
    other = _NEGLIGIBLE * max(of_angles, default=0.0)
    return {
        i: {k: s for k, s in row.items() if s > least.get(k, other)} for i, row in found.items()
    }


def weak_pivot(spread: float) -> float:
    """The part of its reference below which a pivot is weak, for masses of this spread.

    Masses that lie far apart make genuine pivots as much smaller.
    """
    return WEAK_PIVOT if spread < FAR else float(f"{WEAK_PIVOT / spread:.1e}")


def _inertias(scene: SceneGraph) -> dict[int, float]:
    """Coordinate → its mass or moment of inertia, as declared, neutral pose, where it has one."""
    equations = scene.equations
    pose = neutral(equations.coordinates)
    declared = {Parameter(p.name, real=True): p.value for p in equations.parameters}
    sizes = {}
    for i, k, mass in equations.mass:
        if i != k:
            continue
        own = mass.free_symbols  # of these alone: to substitute all takes as long as all masses
        known = mass
        for numbers in (declared, pose) if own else ():
            known = known.subs({symbol: numbers[symbol] for symbol in own if symbol in numbers})
        size = float(known)
        if size > 0.0:
            sizes[k] = size
    return sizes


class _Slopes:
    """The entries of Φ_q in numbers."""

    def __init__(self, scene: SceneGraph) -> None:
        self.places = list(scene.jacobian)
        outputs = tuple(Output("out", s, v) for s, v in enumerate(scene.jacobian.values()))
        kernel = Kernel("slopes", "", (), outputs)
        self.program = Program(tuple(scene.graph.values), (kernel,), (), WEAK_PIVOT)
        self.lengths = [q.unit == "m" for q in scene.equations.coordinates]
        self.p = [p.value for p in scene.equations.parameters]

    def at(self, pose: int) -> dict[tuple[int, int], float]:
        """Entries in a pose; none where one of them has no value there."""
        angles = (math.sin(1.0 + 2.3 * k + 1.7 * pose) * math.pi for k in range(len(self.lengths)))
        pairs = zip(self.lengths, angles, strict=True)
        q = [0.0 if is_length else angle for is_length, angle in pairs]
        arguments = {"t": 0.0, "q": q, "p": self.p}
        try:
            found = evaluate(self.program, "slopes", arguments, math)
        except (ArithmeticError, ValueError, LookupError, TypeError):
            return {}
        return {place: found["out"][s] for s, place in enumerate(self.places)}

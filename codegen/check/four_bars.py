"""Grashof's class of the four-bars of a model.

The shortest link of a four-bar turns all around if it and the longest are together no longer than
the other two (F. Grashof, Theoretische Maschinenlehre, 1883).
"""

from collections import defaultdict
from collections.abc import Sequence
from math import dist

from codegen.check.kinematics import places_on
from codegen.declare.body import Body
from codegen.model import Model

_EQUAL = 1e-9  # accuracy: of the sum of all lengths; sums that differ by less are equal


def four_bars(model: Model, left_out: Sequence[str]) -> tuple[str, ...]:
    """A sentence for each loop of the ground and three links on revolute joints, lengths in m."""
    pins, ground = defaultdict[Body, dict[str, Body]](dict), model.ground
    for name, joint in model.joints.items():
        if joint.kind == "revolute" and name not in left_out:
            one, other = joint.bodies
            pins[one][name], pins[other][name] = other, one
    loops = [
        ((ground, d, a), (crank, a, b), (coupler, b, c), (rocker, c, d))
        for a, crank in pins[ground].items()
        for b, coupler in pins[crank].items() if coupler is not ground
        for c, rocker in pins[coupler].items() if rocker is not crank
        for d, last in pins[rocker].items() if last is ground and a < d
    ]  # fmt: skip
    found = []
    for loop in loops:
        ends = [p for body, *ab in loop for joint in ab for p in places_on(model, joint, body)]
        sizes = [dist(p, q) for p, q in zip(ends[::2], ends[1::2], strict=True)]
        if len(sizes) == len(loop) and min(sizes) > 0.0:
            names, links = zip(*((joint, body.name) for body, _, joint in loop), strict=True)
            found.append(f"{'-'.join(names)}: {_grashof_class(links, sizes)}")
    return tuple(found)


def _grashof_class(links: Sequence[str], sizes: list[float]) -> str:
    """Grashof's class of ground, crank, coupler and rocker."""
    short, p, q, long = sorted(sizes)
    k, excess = sizes.index(short), short + long - p - q
    kind = ("double crank", "crank-rocker", "double rocker", "crank-rocker")[k]
    who = f"{links[k]} turns" if k else f"{links[1]} and {links[3]} turn"
    sign, text = "<", f"{kind}, {who} all around"
    if abs(excess) <= _EQUAL * sum(sizes):
        sign, text = "=", "change point, all four links can lie in one line"
    elif 2.0 * long >= (1.0 - _EQUAL) * sum(sizes):
        text = "cannot close, or only in one line"
        return f"{text} ({long:.6g} >= {short:.6g} + {p:.6g} + {q:.6g} m)"
    elif excess > 0.0:
        sign, text = ">", "triple rocker, no link turns all around"
    return f"{text} ({short:.6g} + {long:.6g} {sign} {p:.6g} + {q:.6g} m)"

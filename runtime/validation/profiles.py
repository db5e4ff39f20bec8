"""Profiles of cams with the parameters of a run: their shapes, and what a run uses of them."""

from functools import partial
from typing import Any

import numpy as np

from codegen.parameter_conditions import ALPHAS, roller_cut, sample_profile
from runtime.core.arrays import matrix, none, vector
from runtime.core.jit import ADDRESSES, compiled
from runtime.core.kernel_abi import profiles_of
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.mechanism import Mechanism
from runtime.results.samples import Samples


@compiled(none(ADDRESSES, vector, vector, matrix))
def write_profiles(kernels: Any, alphas: Any, p: Any, out: Any) -> None:
    """Write x, y and their derivatives of all profiles at α, (k,), into `out`, (k, 6 c)."""
    evaluate = profiles_of(kernels)
    for i in range(alphas.size):
        evaluate(alphas[i], p, out[i])


def sampled_profiles(mechanism: Mechanism, p: FloatArray) -> list[FloatArray]:
    """The profiles of a scene."""
    count = len(mechanism.description.profiles)

    def points(which: int, alphas: FloatArray) -> FloatArray:
        out = np.zeros((len(alphas), 6 * count))
        write_profiles(mechanism.kernel_table, alphas, p, out)
        return out.reshape(-1, count, 6)[:, which]

    return [sample_profile(partial(points, which)) for which in range(count)]


def describe_cuts(mechanism: Mechanism, p: FloatArray, samples: Samples) -> str:
    """A sentence on a roller that cuts into its profile where a run uses it; empty for none."""
    rows = mechanism.description.profiles
    contacts = [k for k, row in enumerate(rows) if row.contact and len(samples.t)]
    curves = sampled_profiles(mechanism, p) if contacts else []
    for k in contacts:
        cut = roller_cut(curves[k], curves[k + 1], rows[k].touches < 0)
        if cut is None:
            continue
        name = f"{rows[k].contact}.{('alpha', 'beta')[cut.which]}"
        at = samples.q[:, mechanism.description.coordinates.index(name)]
        low, high = np.minimum.accumulate(at), np.maximum.accumulate(at)
        ahead = (cut.alphas - low[:, None]) % ALPHAS[-1]  # to each cut from there
        used = np.flatnonzero(low + ahead.min(axis=1) <= high)
        if len(used):
            first = used[0]
            return (
                f"At t = {samples.t[first]:.6g} s, where {name} is {at[first]:.6g} rad: "
                f"{rows[k + cut.which].element}: {cut.sentence}"
            )
    return ""

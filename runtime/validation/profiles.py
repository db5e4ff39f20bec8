"""Profiles of cams with the parameters of a run: their shapes, and what a run uses of them."""

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


def _points(mechanism: Mechanism, p: FloatArray, alphas: FloatArray) -> FloatArray:
    out = np.zeros((len(alphas), 6 * len(mechanism.description.profiles)))
    write_profiles(mechanism.kernel_table, alphas, p, out)
    return out


def profiles_change(mechanism: Mechanism, p: FloatArray) -> bool:
    """Whether a profile differs from that of the defaults, which the build judged."""
    defaults = p.copy()
    parameters = mechanism.description.parameters
    defaults[: len(parameters)] = [row.default for row in parameters]
    mechanism.kernels.constants(defaults)
    one, other = (_points(mechanism, values, np.array(ALPHAS)) for values in (p, defaults))
    return not np.array_equal(one, other)


def sampled_profiles(mechanism: Mechanism, p: FloatArray) -> list[FloatArray]:
    """The profiles of a scene."""

    def column(k: int) -> FloatArray:
        return sample_profile(lambda alphas: _points(mechanism, p, alphas)[:, 6 * k : 6 * k + 6])

    return [column(k) for k in range(len(mechanism.description.profiles))]


def describe_cuts(mechanism: Mechanism, p: FloatArray, samples: Samples) -> str:
    """A sentence on a roller that cuts into its profile where a run uses it; empty for none."""
    description = mechanism.description
    if not any(row.contact for row in description.profiles) or not len(samples.t):
        return ""
    curves = sampled_profiles(mechanism, p)
    for k, row in enumerate(description.profiles):
        cut = row.contact and roller_cut(curves[k], curves[k + 1], row.touches < 0)
        if not cut:
            continue
        name = f"{row.contact}.{('alpha', 'beta')[cut.which]}"
        at = samples.q[:, description.coordinates.index(name)]
        low, high = np.minimum.accumulate(at), np.maximum.accumulate(at)
        turn = ALPHAS[-1]
        ahead = low[:, None] + (cut.alphas - low[:, None]) % turn  # the next cut from there
        used = (ahead.min(axis=1) <= high).nonzero()[0]
        if len(used):
            first = used[0]
            return (
                f"At t = {samples.t[first]:.6g} s, where {name} is {at[first]:.6g} rad: "
                f"{description.profiles[k + cut.which].element}: {cut.sentence}"
            )
    return ""

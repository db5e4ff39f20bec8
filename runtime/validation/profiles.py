"""Profiles of cams with the parameters of a run: their shapes, and what a run uses of them."""

from functools import partial

import numpy as np

from codegen.parameter_conditions import ALPHAS, roller_cut, sample_profile
from runtime.mechanism.dense_equations import FloatArray
from runtime.mechanism.mechanism import Mechanism
from runtime.results.samples import Samples


def sampled_profiles(mechanism: Mechanism, p: FloatArray) -> list[FloatArray]:
    """The profiles of a scene."""
    count = len(mechanism.description.profiles)

    def points(which: int, alphas: FloatArray) -> FloatArray:
        out = np.zeros((len(alphas), 6 * count))
        for at, row in zip(alphas.tolist(), out, strict=True):
            mechanism.kernels.profiles(at, p, row)
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

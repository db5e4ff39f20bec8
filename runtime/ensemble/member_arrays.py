"""The arrays of an ensemble in compiled code: of all members, of a thread, of a block."""

from typing import Any, NamedTuple

from numba import types

from runtime.core import array_types as arrays
from runtime.core.array_types import (
    Integers,
    Matrix,
    Vector,
    f8,
    integer_matrix,
    integers,
    matrix,
    vector,
)
from runtime.dynamics.output_quantities import SAMPLES
from runtime.results.samples import Samples

WAITING, DONE, LEFT = 0, 1, 2
"""What became of a member: not made yet, made, left to `simulate`."""

_cube: Any = types.Array(f8, 3, "C")


class Common(NamedTuple):
    """What all members have in common."""

    values: Matrix  # (r, k): what the members differ in
    kinds: Integers  # (k,): 0: parameters, 1: positions, 2: velocities
    places: Integers  # (k,)
    p: Vector  # parameters before the members' own values, without constants
    q: Vector  # start values likewise, (n,) each
    v: Vector
    absolute: Vector  # (2n,): tolerances that are given, else no number
    diagonal: Integers  # (nm,): coordinate of a non-zero of M on its diagonal, else -1
    bodies: Integers  # (n,): 1 of coordinates that need a mass
    low: Vector  # (c,): bounds of the conditions on parameters; no number: none
    high: Vector
    beyond: Integers  # (c,): 1 where the least value is itself too small
    first: Integers  # (c,): place of each condition's number
    t: float  # first instant, s
    widest: float  # spread of the masses from which on kernels may not suit them; infinite: none
    part: float  # of a typical size, that a residual may reach
    near: float  # s; events are nearer to their instants


class Own(NamedTuple):
    """What a thread has of its own: the table of a run, its memory before a run, and room."""

    table: Integers
    block: Integers  # memory of the table's arrays
    record: Integers  # the record of the run
    fresh_table: Integers
    fresh_block: Integers
    fresh_record: Integers
    p: Vector
    q: Vector
    v: Vector
    sizes: Vector
    mobility: Vector
    inertia: Vector
    masses: Vector
    numbers: Vector  # of the conditions
    start: Integers  # the table of `start_table`
    samples: Samples
    modes: Matrix  # (k, s) of int64: those of the samples, 0 and 1
    slopes: Vector
    phi: Vector
    scratch: Matrix  # of the screening
    switches: Matrix  # (2, s) of int64
    reversed_event: Integers  # (e,)
    reached: Vector  # (e,)
    permitted: Vector  # (s,)
    begun: Integers  # (1,): the member that has begun, or -1
    mixing_table: Integers  # of `mix_rows`, as the next two; of no words where nothing slides
    mixing_block: Integers
    fresh_mixing: Integers
    powers: Matrix  # (2, rows of POWERS)


class Results(NamedTuple):
    """What becomes of the members, and the samples of a block of them."""

    samples: Samples  # each of one more dimension, in front: the members of the block
    status: Integers  # (r,) of all members, as the others
    steps: Integers
    events: Integers  # that results show
    logged: Integers  # all of them
    unresolved: Any  # (r, s, 4): events within the tolerance, see `count_unresolved`


COMMON = arrays.named_tuple_type(
    [
        matrix, integers, integers, vector, vector, vector, vector, integers,
        integers, vector, vector, integers, integers, f8, f8, f8, f8,
    ], Common,
)  # fmt: skip
OWN = arrays.named_tuple_type(
    [
        *[integers] * 6, *[vector] * 8, integers, SAMPLES, integer_matrix, vector, vector, matrix,
        integer_matrix, integers, vector, vector, integers, integers, integers, integers, matrix,
    ], Own,
)  # fmt: skip
RESULTS = arrays.named_tuple_type(
    [arrays.named_tuple_type([matrix, *[_cube] * 10], Samples), *[integers] * 4, _cube], Results
)

"""Elimination of large sparse matrices: an order of pivots, and its elimination row by row.

The order is Markowitz's with a threshold: of the rows that still have a large entry the shortest
gives the pivot, in the column of fewest rows among its larger entries. Of rows of one length the
one at the end of the shortest chain of eliminations does: null vectors and left vectors, which
follow such chains, then have few entries. Rows without a large entry wait, so that pivots come
about in order of size and weak rows last. The elimination follows a given
order and meets no entries but those that are there. (T. A. Davis, Direct Methods for Sparse Linear
Systems, 2006, chapters 6 and 7; I. S. Duff, A. M. Erisman and J. K. Reid, Direct Methods for Sparse
Matrices, 2017, chapters 7 and 10.)

Sparse matrices are NamedTuples of arrays by rows: `starts`, (m + 1,), `columns` and `values`.
"""

from typing import NamedTuple

import numpy as np

from runtime.core.arrays import Integers, Vector
from runtime.core.jit import inner, inner_allocating

_SHARE = 0.5  # measured: of a row's largest entry, above which an entry may be the pivot
_LEVEL = 0.5  # measured: of the largest entry left; rows with none above it wait
_DROPPED = 1e-14  # safety: entries below, in rows of size 1, are rounding


class SparseRows(NamedTuple):
    """A sparse matrix by rows."""

    starts: Integers  # (m + 1,): where each row begins
    columns: Integers
    values: Vector


@inner_allocating
def by_rows(rows: Integers, columns: Integers, values: Vector, m: int) -> SparseRows:
    """The matrix with these entries, of m rows; entries of a row in their order."""
    starts, place = np.zeros(m + 1, np.int64), np.empty(m, np.int64)
    for e in range(rows.size):
        starts[rows[e] + 1] += 1
    for i in range(m):
        starts[i + 1] += starts[i]
        place[i] = starts[i]
    kept, numbers = np.empty(rows.size, np.int64), np.empty(rows.size)
    for e in range(rows.size):
        at = place[rows[e]]
        kept[at], numbers[at] = columns[e], values[e]
        place[rows[e]] = at + 1
    return SparseRows(starts, kept, numbers)


@inner_allocating
def larger(array: Integers, size: int) -> Integers:
    """The array with room for `size` integers."""
    grown = np.empty(size, np.int64)
    grown[: array.size] = array
    return grown


@inner_allocating
def larger_vector(array: Vector, size: int) -> Vector:
    """The array with room for `size` numbers."""
    grown = np.empty(size)
    grown[: array.size] = array
    return grown


@inner_allocating
def order_sparsely(
    matrix: SparseRows, n: int, least: float, row_order: Integers, column_order: Integers
) -> int:
    """Order rows, (m,), and columns, (n,), by pivots; count those above `least`.

    Rows of the matrix have entries of the size 1. The first of `row_order` and `column_order`
    belong together; behind them stand the rows and columns without a pivot.
    """
    m = row_order.size
    size = 2 * matrix.columns.size + 8 * n
    columns, values = np.empty(size, np.int64), np.empty(size)
    columns[: matrix.columns.size], values[: matrix.columns.size] = matrix.columns, matrix.values
    end = matrix.columns.size
    start, length, largest = matrix.starts[:m].copy(), np.zeros(m, np.int64), np.zeros(m)
    # Rows of each column, as lists of nodes; some have lost the entry since.
    head, count, nodes = np.full(n, -1), np.zeros(n, np.int64), matrix.columns.size
    node_row, node_next = np.empty(size, np.int64), np.empty(size, np.int64)
    for i in range(m):
        length[i] = matrix.starts[i + 1] - start[i]
        for e in range(start[i], start[i] + length[i]):
            j = columns[e]
            largest[i] = max(largest[i], abs(values[e]))
            node_row[e], node_next[e] = i, head[j]
            head[j] = e
            count[j] += 1
    taken_row, taken_column = np.zeros(m, np.bool_), np.zeros(n, np.bool_)
    where, seen, level, rank = np.zeros(n, np.int64), np.full(m, -1), np.inf, 0
    chain = np.zeros(m, np.int64)  # of eliminations that a row depends on
    while rank < min(m, n):
        best, row = (n + 1) * (m + 1), -1
        most = 0.0
        for i in range(m):
            if not taken_row[i]:
                most = max(most, largest[i])
                if largest[i] > level and length[i] * (m + 1) + chain[i] < best:
                    best, row = length[i] * (m + 1) + chain[i], i
        if row < 0:
            if not most > least:
                break
            level = max(_LEVEL * most, least)
            continue
        chosen = -1
        for e in range(start[row], start[row] + length[row]):
            if abs(values[e]) >= _SHARE * largest[row] and (
                chosen < 0 or count[columns[e]] < count[columns[chosen]]
            ):
                chosen = e
        column, pivot = columns[chosen], values[chosen]
        row_order[rank], column_order[rank] = row, column
        rank += 1
        taken_row[row], taken_column[column] = True, True
        node = head[column]
        while node >= 0:
            i, node = node_row[node], node_next[node]
            if taken_row[i] or seen[i] == column:
                continue
            seen[i] = column
            chain[i] = max(chain[i], chain[row] + 1)
            if end + length[i] + length[row] > columns.size:
                live = 0
                for k in range(m):
                    live += length[k]
                size = 2 * (live + length[i] + length[row]) + columns.size
                fresh, numbers, end = np.empty(size, np.int64), np.empty(size), 0
                for k in range(m):
                    for e in range(start[k], start[k] + length[k]):
                        fresh[end + e - start[k]] = columns[e]
                        numbers[end + e - start[k]] = values[e]
                    start[k] = end
                    end += length[k]
                columns, values = fresh, numbers
            factor, first = 0.0, end
            for e in range(start[i], start[i] + length[i]):
                if columns[e] == column:
                    factor = values[e] / pivot
                else:
                    columns[end], values[end] = columns[e], values[e]
                    end += 1
                    where[columns[e]] = end
            for e in range(start[row], start[row] + length[row]):
                j = columns[e]
                if j == column or factor == 0.0:
                    continue
                if where[j] > 0:
                    values[where[j] - 1] -= factor * values[e]
                else:
                    columns[end], values[end] = j, -factor * values[e]
                    end += 1
                    if nodes == node_row.size:
                        node_row = larger(node_row, 2 * nodes)
                        node_next = larger(node_next, 2 * nodes)
                    node_row[nodes], node_next[nodes] = i, head[j]
                    head[j] = nodes
                    nodes += 1
                    count[j] += 1
            kept, largest[i] = first, 0.0
            for e in range(first, end):
                where[columns[e]] = 0
                if abs(values[e]) > _DROPPED:
                    columns[kept], values[kept] = columns[e], values[e]
                    largest[i] = max(largest[i], abs(values[e]))
                    kept += 1
            start[i], length[i], end = first, kept - first, kept
        length[row] = 0
    at = rank
    for i in range(m):
        if not taken_row[i]:
            row_order[at] = i
            at += 1
    at = rank
    for j in range(n):
        if not taken_column[j]:
            column_order[at] = j
            at += 1
    return rank


@inner
def push(heap: Integers, count: int, number: int) -> None:
    """Add a number to a heap of `count` integers, the smallest first."""
    at = count
    while at > 0:
        above = (at - 1) // 2
        if heap[above] <= number:
            break
        heap[at] = heap[above]
        at = above
    heap[at] = number


@inner
def pop(heap: Integers, count: int) -> int:
    """Take the smallest of the `count` integers of a heap."""
    smallest, last = heap[0], heap[count - 1]
    count -= 1
    at = 0
    while 2 * at + 1 < count:
        below = 2 * at + 1
        if below + 1 < count and heap[below + 1] < heap[below]:
            below += 1
        if last <= heap[below]:
            break
        heap[at] = heap[below]
        at = below
    heap[at] = last
    return int(smallest)


@inner_allocating
def eliminate_in_order(
    matrix: SparseRows, n: int, strong: int, right: Vector, least: float
) -> SparseRows:
    """Eliminate the first `strong` columns from the rows behind, each row by those before it.

    Rows and columns of the matrix stand in the order of pivots. Returns U, its pivots first in
    their rows, and behind `strong` the Schur complement; `right`, (m,), is eliminated with them.
    A pivot that is no larger than `least` eliminates nothing.
    """
    m = matrix.starts.size - 1
    size = 4 * matrix.columns.size + 4 * n
    starts, columns, values = np.zeros(m + 1, np.int64), np.empty(size, np.int64), np.empty(size)
    x, known = np.zeros(n), np.zeros(n, np.bool_)
    touched, heap = np.empty(n, np.int64), np.empty(n, np.int64)
    end = 0
    for k in range(m):
        bound, count, pending = min(k, strong), 0, 0
        for e in range(matrix.starts[k], matrix.starts[k + 1]):
            j = matrix.columns[e]
            x[j] += matrix.values[e]
            if not known[j]:
                known[j], touched[count] = True, j
                count += 1
                if j < bound:
                    push(heap, pending, j)
                    pending += 1
        while pending > 0:
            s = pop(heap, pending)
            pending -= 1
            pivot = values[starts[s]] if starts[s] < starts[s + 1] else 0.0
            if not abs(pivot) > least or abs(x[s]) < _DROPPED:
                continue
            ratio = x[s] / pivot
            for e in range(starts[s] + 1, starts[s + 1]):
                j = columns[e]
                x[j] -= ratio * values[e]
                if not known[j]:
                    known[j], touched[count] = True, j
                    count += 1
                    if j < bound:
                        push(heap, pending, j)
                        pending += 1
            right[k] -= ratio * right[s]
        if end + count + 1 > columns.size:
            columns = larger(columns, 2 * columns.size + count)
            values = larger_vector(values, columns.size)
        if k < strong:
            columns[end], values[end] = k, x[k]
            end += 1
        for c in range(count):
            j = touched[c]
            if j >= bound and not (j == k and k < strong) and abs(x[j]) > _DROPPED:
                columns[end], values[end] = j, x[j]
                end += 1
            x[j], known[j] = 0.0, False
        starts[k + 1] = end
    return SparseRows(starts, columns[:end].copy(), values[:end].copy())


@inner_allocating
def complete_sparsely(upper: SparseRows, n: int, strong: int) -> SparseRows:
    """The first `strong` rows W of the null vectors [W; I] of an eliminated matrix, by rows.

    U of the first rows is `upper`, of which the columns behind `strong` belong to the identity:
    U_s W + U_f = 0. Columns of W are counted from `strong`.
    """
    size = 4 * upper.columns.size + n
    starts, stops = np.zeros(strong, np.int64), np.zeros(strong, np.int64)
    columns, values, end = np.empty(size, np.int64), np.empty(size), 0
    x, known, touched = np.zeros(n), np.zeros(n, np.bool_), np.empty(n, np.int64)
    for s in range(strong - 1, -1, -1):
        count, pivot = 0, upper.values[upper.starts[s]]
        for e in range(upper.starts[s] + 1, upper.starts[s + 1]):
            j, value = upper.columns[e], upper.values[e]
            if j >= strong:
                x[j - strong] -= value
                if not known[j - strong]:
                    known[j - strong], touched[count] = True, j - strong
                    count += 1
                continue
            for f in range(starts[j], stops[j]):
                at = columns[f]
                x[at] -= value * values[f]
                if not known[at]:
                    known[at], touched[count] = True, at
                    count += 1
        if end + count > columns.size:
            columns = larger(columns, 2 * columns.size + count)
            values = larger_vector(values, columns.size)
        starts[s] = end
        for c in range(count):
            j = touched[c]
            if abs(x[j]) > _DROPPED * abs(pivot):
                columns[end], values[end] = j, x[j] / pivot
                end += 1
            x[j], known[j] = 0.0, False
        stops[s] = end
    ordered, kept, numbers = np.zeros(strong + 1, np.int64), np.empty(end, np.int64), np.empty(end)
    at = 0
    for s in range(strong):
        for e in range(starts[s], stops[s]):
            kept[at], numbers[at] = columns[e], values[e]
            at += 1
        ordered[s + 1] = at
    return SparseRows(ordered, kept, numbers)

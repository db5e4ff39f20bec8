"""Ways in from Python to searches that only compiled code calls; numba keeps them on disk."""

from runtime.core.arrays import f8, i8, integers, matrix, vector
from runtime.core.jit import compiled
from runtime.singularity import schur_complement, singular_root_search


@compiled(f8(integers, vector, i8, matrix, vector, matrix, matrix, matrix, matrix))
def lost_gap(table, z, strong, a, gaps, left, null, square, normal):
    """Largest |uᵀ Φ| at z, the complement normalised; -1 where there is none."""
    if not schur_complement.eliminate_strong_rows(table, z, strong, a, gaps):
        return -1.0
    schur_complement.find_vectors(table, a, strong, left, null)
    if not schur_complement.normalise_complement(a, strong, left, null, square, normal):
        return -1.0
    return schur_complement.largest_lost_gap(gaps, strong, square)


@compiled(i8(integers, vector, matrix, matrix, matrix, matrix))
def factor_normal_equations(table, z, left, null, form, normal):
    return int(singular_root_search.factor_normal_equations(table, z, left, null, form, normal))

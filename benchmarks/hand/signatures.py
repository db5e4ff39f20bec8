"""How the hand-written twins are compiled: with the signatures and options of generated kernels."""

from typing import Any

import numba

OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "fastmath": {"contract"}}

small = numba.njit(**OPTIONS)
"""A few lines that several twins of a file share; the compiler puts them where they are called."""
woven = numba.njit(inline="always", **OPTIONS)
"""Longer ones, which the compiler would leave where they are and call."""
position = numba.njit("void(f8, f8[::1], f8[::1], f8[::1])", **OPTIONS)
"""Φ_q: t, q, p, values."""
velocity = numba.njit("void(f8, f8[::1], f8[::1], f8[::1], f8[::1])", **OPTIONS)
"""γ: t, q, v, p, gamma."""
force = numba.njit("void(f8, f8[::1], f8[::1], f8[::1], i8[::1], f8[::1])", **OPTIONS)
"""Q: t, q, v, p, modes, Q."""
solution = numba.njit("i8(f8, f8[::1], f8[::1], f8[::1], i8[::1], f8[::1], f8[::1])", **OPTIONS)
"""q̈ and λ: t, q, v, p, modes, a, lam."""
power = numba.njit("void(f8, f8[::1], f8[::1], f8[::1], i8[::1], f8[::1], f8[::1])", **OPTIONS)
"""Powers of effects: t, q, v, p, modes, lam, out."""

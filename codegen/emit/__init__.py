"""Program → text of a numba module that a person can read."""

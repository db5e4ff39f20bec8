"""Unit roundoff of double precision, in its one spelling."""

EPS = 2.0**-52  # distance from 1.0 to the next float64, the relative spacing of numbers

"""By how much the energy of a right run may miss its balance, in the loop and between samples."""

ERRORS = 50.0  # measured: tolerances of a step by which its energy may err
PART = 1e-3  # safety: of the energy that a step exchanges, which need not be explained
ROUNDING = 1e-13  # accuracy: of an energy; rounding of the sums that it is made of
CERTAIN = 16.0  # measured: times the scatter of a potential that two values may be apart

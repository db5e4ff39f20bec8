"""
Valve lifter
============

Section 8.5 of the book: an eccentric cam lifts a pushrod with a flat face, a rocker opens the
valve against its spring. The force between cam and pushrod must not be negative.
"""

# %%
# Declared in :download:`valve_lifter.py <../../../models/valve_lifter.py>`; at its start:

from gallery_parts import BesideTheBook, figures_of_the_book

import linkwright as lw

machine = lw.load("valve_lifter", scene="inverse_dynamics")
machine.draw()

# %%
# Its motion:

result = machine.inverse_dynamics(0.04)
result.animate()

# %%
# Curves:

result.plot("valve.y", "lift.fy")

# %%
# How the run ended:

print(result)

# %%
# Our numbers beside the book's. "Exact" is an independent solution in extended precision or a
# closed form, "book" the printed value:

BesideTheBook("valve_lifter")

# %%
# The figures of the book, with our numbers:

figures_of_the_book("valve_lifter")

"""
Four-bar linkage
================

Section 5.3 of the book, in Hoeken's proportions: over half a turn of the crank a point of the
coupler runs along a straight line.
"""

# %%
# Declared in :download:`four_bar.py <../../../models/four_bar.py>`; at its start:

from gallery_parts import BesideTheBook, figures_of_the_book

import linkwright as lw

machine = lw.load("four_bar", scene="kinematics")
machine.draw()

# %%
# Its motion:

result = machine.kinematics(1.0)
result.animate()

# %%
# Curves:

result.plot("coupler.phi", "rocker.phi")

# %%
# How the run ended:

print(result)

# %%
# Our numbers beside the book's. "Exact" is an independent solution in extended precision or a
# closed form, "book" the printed value:

BesideTheBook("four_bar")

# %%
# The figures of the book, with our numbers:

figures_of_the_book("four_bar")

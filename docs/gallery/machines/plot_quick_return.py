"""
Quick-return shaper
===================

Section 8.3 of the book: the pin of a crank carries a block along a rocker, and a rod from the
tip of the rocker moves the tool, slowly on the cut and quickly on the way back.
"""

# %%
# Declared in :download:`quick_return.py <../../../models/quick_return.py>`; at its start:

from gallery_parts import BesideTheBook, figures_of_the_book

import linkwright as lw

machine = lw.load("quick_return", scene="shaper")
machine.draw()

# %%
# Its motion:

result = machine.simulate(2.0)
result.animate()

# %%
# Curves:

result.plot("crank.omega", "slider.x")

# %%
# How the run ended:

print(result)

# %%
# Our numbers beside the book's. "Exact" is an independent solution in extended precision or a
# closed form, "book" the printed value:

BesideTheBook("quick_return")

# %%
# The figures of the book, with our numbers:

figures_of_the_book("quick_return")

"""
Rack and pinion
===============

Projects 5.3 and 8.3 of the book: a pinion rolls along a rack whose end is pinned to a coupler.
The rack slides to and fro and rocks about the pinion.
"""

# %%
# Declared in :download:`rack_and_pinion.py <../../../models/rack_and_pinion.py>`; at its start:

from gallery_parts import BesideTheBook, figures_of_the_book

import linkwright as lw

machine = lw.load("rack_and_pinion", scene="running")
machine.draw()

# %%
# Its motion:

result = machine.simulate(1.0)
result.animate()

# %%
# Curves:

result.plot("pinion.omega", "rack.phi")

# %%
# How the run ended:

print(result)

# %%
# Our numbers beside the book's. "Exact" is an independent solution in extended precision or a
# closed form, "book" the printed value:

BesideTheBook("rack_and_pinion")

# %%
# The figures of the book, with our numbers:

figures_of_the_book("rack_and_pinion")

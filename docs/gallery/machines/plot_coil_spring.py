"""
Coil spring
===========

Section 8.4 of the book: a long spring as lumps of mass on springs. The last mass is struck,
and a surge runs along the spring.
"""

# %%
# Declared in :download:`coil_spring.py <../../../models/coil_spring.py>`; at its start:

from gallery_parts import BesideTheBook, figures_of_the_book

import linkwright as lw

machine = lw.load("coil_spring", scene="surge")
machine.draw()

# %%
# Its motion:

result = machine.simulate(20.0)
result.animate()

# %%
# Curves:

result.plot("mass_1.x", "mass_6.x")

# %%
# How the run ended:

print(result)

# %%
# Our numbers beside the book's. "Exact" is an independent solution in extended precision or a
# closed form, "book" the printed value:

BesideTheBook("coil_spring")

# %%
# The figures of the book, with our numbers:

figures_of_the_book("coil_spring")

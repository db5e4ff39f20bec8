"""
Compressor
==========

Section 8.2 of Haug's book: a crank with a flywheel, a rod, and a slider that compresses gas
along the x axis. With a light flywheel the compression stops the crank.
"""

# %%
# Declared in :download:`slider_crank.py <../../../models/slider_crank.py>`; at its start:

from gallery_parts import BesideTheBook, figures_of_the_book

import linkwright as lw

machine = lw.load("slider_crank", scene="compressor")
machine.draw()

# %%
# Its motion:

result = machine.simulate(1.0)
result.animate()

# %%
# Curves:

result.plot("crank.omega", "slider.x", "A.fx")

# %%
# How the run ended:

print(result)

# %%
# Our numbers beside the book's. "Exact" is an independent solution in extended precision or a
# closed form, "book" the printed value:

BesideTheBook("compressor")

# %%
# The figures of the book, with our numbers:

figures_of_the_book("compressor")

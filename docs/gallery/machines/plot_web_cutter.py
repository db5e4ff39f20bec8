"""
Web cutter
==========

Projects 5.2 and 8.2 of the book: a crank-rocker linkage with a knife on the coupler and one on
the rocker. Once a turn the tips pass each other and shear off the web that runs through.
"""

# %%
# Declared in :download:`web_cutter.py <../../../models/web_cutter.py>`; at its start:

from gallery_parts import BesideTheBook, figures_of_the_book

import linkwright as lw

machine = lw.load("web_cutter", scene="running")
machine.draw()

# %%
# Its motion:

result = machine.simulate(1.0)
result.animate()

# %%
# Curves:

result.plot("crank.omega", "rocker.phi")

# %%
# How the run ended:

print(result)

# %%
# Our numbers beside the book's. "Exact" is an independent solution in extended precision or a
# closed form, "book" the printed value:

BesideTheBook("web_cutter")

# %%
# The figures of the book, with our numbers:

figures_of_the_book("web_cutter")

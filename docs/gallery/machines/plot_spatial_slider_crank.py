"""
Spatial slider-crank
====================

Section 12.2 of the book: a crank moves a slider along a line that lies below and beside it, by a
rod with a ball joint and a cross.
"""

# %%
# Declared in
# :download:`spatial_slider_crank.py <../../../models/space/spatial_slider_crank.py>`;
# at its start:

from gallery_parts import BesideTheBook, figures_of_the_book

import linkwright as lw

machine = lw.load("space/spatial_slider_crank", scene="free")
machine.draw()

# %%
# Its motion:

result = machine.simulate(2.0)
result.animate()

# %%
# Curves:

result.plot("slider.x", "A.rate", "B.fx")

# %%
# How the run ended:

print(result)

# %%
# Our numbers beside the book's. "Exact" is an independent solution in extended precision or a
# closed form, "book" the printed value:

BesideTheBook("spatial_slider_crank")

# %%
# The curves of the section, with our numbers:

figures_of_the_book("spatial_slider_crank")

"""
Spatial four-bar
================

Section 12.3 of the book: a wheel swings a rocker whose axis is perpendicular to its own, by a long
link.
"""

# %%
# Declared in
# :download:`spatial_four_bar.py <../../../models/space/spatial_four_bar.py>`;
# at its start:

from gallery_parts import BesideTheBook, figures_of_the_book

import linkwright as lw

machine = lw.load("space/spatial_four_bar", scene="inverse_dynamics")
machine.draw()

# %%
# Its motion:

result = machine.inverse_dynamics(2.0)
result.animate()

# %%
# Curves:

result.plot("rocker.z", "drive.torque")

# %%
# How the run ended:

print(result)

# %%
# Our numbers beside the book's. "Exact" is an independent solution in extended precision or a
# closed form, "book" the printed value:

BesideTheBook("spatial_four_bar")

# %%
# The curves of the section, with our numbers:

figures_of_the_book("spatial_four_bar")

"""
Air compressor
==============

Section 12.4 of the book: a disc on a tilted hub wobbles on a turning shaft, and moves six pistons
parallel to it.
"""

# %%
# Declared in
# :download:`swash_plate_compressor.py <../../../models/space/swash_plate_compressor.py>`;
# at its start:

from gallery_parts import BesideTheBook, figures_of_the_book

import linkwright as lw

machine = lw.load("space/swash_plate_compressor", scene="kinematics")
machine.draw()

# %%
# Its motion:

result = machine.kinematics(0.2)
result.animate()

# %%
# Curves:

result.plot("piston_1.z", "piston_2.z", "piston_3.z")

# %%
# How the run ended:

print(result)

# %%
# Our numbers beside the book's. "Exact" is an independent solution in extended precision or a
# closed form, "book" the printed value:

BesideTheBook("swash_plate_compressor")

# %%
# The curves of the section, with our numbers:

figures_of_the_book("swash_plate_compressor")

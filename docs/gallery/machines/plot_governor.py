"""
Governor
========

Section 12.6 of the book: balls on arms lift a collar with the speed, and the engine gives the less
torque, the higher the collar is.
"""

# %%
# Declared in
# :download:`governor.py <../../../models/space/governor.py>`;
# at its start:

from gallery_parts import BesideTheBook, figures_of_the_book

import linkwright as lw

machine = lw.load("space/governor", scene="run")
machine.draw()

# %%
# Its motion:

result = machine.simulate(10.0)
result.animate()

# %%
# Curves:

result.plot("spindle.omega_y", "collar.y")

# %%
# How the run ended:

print(result)

# %%
# Our numbers beside the book's. "Exact" is an independent solution in extended precision or a
# closed form, "book" the printed value:

BesideTheBook("governor")

# %%
# The curves of the section, with our numbers:

figures_of_the_book("governor")

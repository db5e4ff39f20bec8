"""
Gear train with a slider
========================

After section 5.5 of the book: a pinion drives a wheel of twice its size, and a rod from a pin
on the wheel moves a slider.
"""

# %%
# Declared in :download:`gear_slider.py <../../../models/gear_slider.py>`; at its start:

from gallery_parts import BesideTheBook, figures_of_the_book

import linkwright as lw

machine = lw.load("gear_slider", scene="train_running")
machine.draw()

# %%
# Its motion:

result = machine.simulate(1.0)
result.animate()

# %%
# Curves:

result.plot("wheel.omega", "slider.x")

# %%
# How the run ended:

print(result)

# %%
# Our numbers beside the book's. "Exact" is an independent solution in extended precision or a
# closed form, "book" the printed value:

BesideTheBook("gear_slider")

# %%
# The figures of the book, with our numbers:

figures_of_the_book("gear_slider")

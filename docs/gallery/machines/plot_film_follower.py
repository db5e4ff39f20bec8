"""
Film follower
=============

Projects 5.1 and 8.1 of the book: a crank of 15 mm drives a coupler whose hook advances a film
by one picture in each turn.
"""

# %%
# Declared in :download:`film_follower.py <../../../models/film_follower.py>`; at its start:

from gallery_parts import BesideTheBook, figures_of_the_book

import linkwright as lw

machine = lw.load("film_follower", scene="kinematics")
machine.draw()

# %%
# Its motion:

result = machine.kinematics(1.0)
result.animate()

# %%
# Curves:

result.plot("coupler.phi", "rocker.phi")

# %%
# How the run ended:

print(result)

# %%
# Our numbers beside the book's. "Exact" is an independent solution in extended precision or a
# closed form, "book" the printed value:

BesideTheBook("film_follower")

# %%
# The figures of the book, with our numbers:

figures_of_the_book("film_follower")

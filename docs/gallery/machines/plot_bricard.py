"""
Bricard's linkage
=================

Six hinges along the edges of a cube: no count of freedoms lets it move, and yet it falls. One of
its rows follows from the others.
"""

# %%
# Declared in
# :download:`bricard.py <../../../models/space/bricard.py>`;
# at its start:

import linkwright as lw

machine = lw.load("space/bricard", scene="fall")
machine.draw()

# %%
# Its motion:

result = machine.simulate(4.0)
result.animate()

# %%
# Curves:

result.plot("b3.x", "b3.y", "b3.z")

# %%
# How the run ended:

print(result)

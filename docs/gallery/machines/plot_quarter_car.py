"""
Quarter car
===========

Double wishbones, a strut, and a tyre on a road with a bump of 60 mm. The tyre never pulls: the
wheel leaves the ground behind the bump.
"""

# %%
# Declared in :download:`quarter_car.py <../../../models/quarter_car.py>`; at its start:

import linkwright as lw

machine = lw.load("quarter_car", scene="bump")
machine.draw()

# %%
# Its motion:

result = machine.simulate(1.0, start=machine.equilibrium())
result.animate()

# %%
# Curves:

result.plot("chassis.y", "upright.y")

# %%
# How the run ended:

print(result)

"""
Scotch yoke
===========

A pump with Coulomb friction in its slot and in its guide. A motor whose torque falls with the
speed starts it from rest.
"""

# %%
# Declared in :download:`scotch_yoke.py <../../../models/scotch_yoke.py>`; at its start:

import linkwright as lw

machine = lw.load("scotch_yoke", scene="running")
machine.draw()

# %%
# Its motion:

result = machine.simulate(2.0)
result.animate()

# %%
# Curves:

result.plot("crank.omega", "yoke.x")

# %%
# How the run ended:

print(result)

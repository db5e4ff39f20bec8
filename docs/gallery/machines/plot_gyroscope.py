"""
Gyroscope
=========

A rotor in two gimbals, with a weight on its axis: it nods and precesses about the upright axis.
"""

# %%
# Declared in
# :download:`gyroscope.py <../../../models/space/gyroscope.py>`;
# at its start:

import linkwright as lw

machine = lw.load("space/gyroscope", scene="precession")
machine.draw()

# %%
# Its motion:

result = machine.simulate(3.0)
result.animate()

# %%
# Curves:

result.plot("tilting.angle", "turning.angle")

# %%
# How the run ended:

print(result)

"""
Heavy top
=========

A top on a fixed point, whose axis lies level at the start: it nutates and precesses.
"""

# %%
# Declared in
# :download:`heavy_top.py <../../../models/space/heavy_top.py>`;
# at its start:

import linkwright as lw

machine = lw.load("space/heavy_top", scene="spin")
machine.draw()

# %%
# Its motion:

result = machine.simulate(3.0)
result.animate()

# %%
# Curves:

result.plot("top.x", "top.y", "top.z")

# %%
# How the run ended:

print(result)

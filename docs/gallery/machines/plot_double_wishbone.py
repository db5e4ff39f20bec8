"""
Double wishbone
===============

The suspension of a front wheel with its steering rack: camber and toe while the wheel is lifted and
steered.
"""

# %%
# Declared in
# :download:`double_wishbone.py <../../../models/space/double_wishbone.py>`;
# at its start:

import linkwright as lw

machine = lw.load("space/double_wishbone", scene="guided")
machine.draw()

# %%
# Its motion:

result = machine.inverse_dynamics(1.0)
result.animate()

# %%
# Curves:

result.plot("camber", "toe", "road.fz")

# %%
# How the run ended:

print(result)

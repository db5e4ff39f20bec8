"""
Engine
======

A four-stroke engine with one cylinder. The pressure of its gas is a table over two turns of
the crank.
"""

# %%
# Declared in :download:`engine.py <../../../models/engine.py>`; at its start:

import linkwright as lw

machine = lw.load("engine", scene="firing")
machine.draw()

# %%
# Its motion:

result = machine.simulate(0.5)
result.animate()

# %%
# Curves:

result.plot("crank.omega", "A.fx")

# %%
# How the run ended:

print(result)

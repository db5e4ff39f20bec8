"""
Trebuchet
=========

A beam with a hinged counterweight and a sling, from the trigger to the landing of the ball, in
one run: the ball leaves the trough, and the sling lets go.
"""

# %%
# Declared in :download:`trebuchet.py <../../../models/trebuchet.py>`; at its start:

import numpy as np

import linkwright as lw

machine = lw.load("trebuchet", scene="throw")
machine.draw()

# %%
# Its motion until the ball has left, in slow motion:

result = machine.simulate(20.0)
result.at(np.linspace(0.0, 1.6, 401)).animate()

# %%
# Curves:

result.plot("ball.x", "ball.y")

# %%
# How the run ended:

print(result)

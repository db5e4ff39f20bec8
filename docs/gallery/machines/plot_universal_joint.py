"""
Universal joint
===============

Two shafts that meet at an angle: the first turns evenly, the second faster and slower twice a turn.
"""

# %%
# Declared in
# :download:`universal_joint.py <../../../models/space/universal_joint.py>`;
# at its start:

import linkwright as lw

machine = lw.load("space/universal_joint", scene="driven")
machine.draw()

# %%
# Its motion:

result = machine.inverse_dynamics(6.2832)
result.animate()

# %%
# Curves:

result.plot("first.omega_x", "second.omega_x")

# %%
# How the run ended:

print(result)

"""
Watt six-bar linkage
====================

A four-bar linkage whose coupler and rocker carry two more links in a second loop. A
constant torque drives the crank against gravity and a spring.
"""

# %%
# Declared in :download:`watt_six_bar.py <../../../models/watt_six_bar.py>`; at its start:

import linkwright as lw

machine = lw.load("watt_six_bar", scene="constant_torque")
machine.draw()

# %%
# Its motion:

result = machine.simulate(2.0)
result.animate()

# %%
# Curves:

result.plot("crank.omega", "right.phi")

# %%
# How the run ended:

print(result)

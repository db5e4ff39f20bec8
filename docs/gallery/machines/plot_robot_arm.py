"""
Robot arm
=========

Three revolute joints with motors under PD control, sampled at 1 kHz, with torques that
saturate.
"""

# %%
# Declared in :download:`robot_arm.py <../../../models/robot_arm.py>`; at its start:

import linkwright as lw

machine = lw.load("robot_arm", scene="sampled")
machine.draw()

# %%
# Its motion:

result = machine.simulate(2.0)
result.animate()

# %%
# Curves:

result.plot("upper.phi", "fore.phi", "hand.phi")

# %%
# How the run ended:

print(result)

"""
Arm with six hinges
===================

A robot arm along a smooth motion, with the torques of its six motors.
"""

# %%
# Declared in
# :download:`six_revolute_arm.py <../../../models/space/six_revolute_arm.py>`;
# at its start:

import linkwright as lw

machine = lw.load("space/six_revolute_arm", scene="inverse_dynamics")
machine.draw()

# %%
# Its motion:

result = machine.inverse_dynamics(2.0)
result.animate()

# %%
# Curves:

result.plot("motor_1.torque", "motor_2.torque", "motor_3.torque")

# %%
# How the run ended:

print(result)

"""
SCARA arm
=========

Two hinges with upright axes and a quill that slides and turns, from one place to another and back.
"""

# %%
# Declared in
# :download:`scara.py <../../../models/space/scara.py>`;
# at its start:

import linkwright as lw

machine = lw.load("space/scara", scene="inverse_dynamics")
machine.draw()

# %%
# Its motion:

result = machine.inverse_dynamics(2.0)
result.animate()

# %%
# Curves:

result.plot("motor_1.torque", "motor_2.torque", "motor_3.force")

# %%
# How the run ended:

print(result)

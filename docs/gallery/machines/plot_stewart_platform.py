"""
Stewart platform
================

A plate on six legs whose lengths are driven: its place and its attitude follow, with the forces in
the legs.
"""

# %%
# Declared in
# :download:`stewart_platform.py <../../../models/space/stewart_platform.py>`;
# at its start:

import linkwright as lw

machine = lw.load("space/stewart_platform", scene="legs")
machine.draw()

# %%
# Its motion:

result = machine.inverse_dynamics(2.0)
result.animate()

# %%
# Curves:

result.plot("plate.x", "plate.z", "leg_1.force")

# %%
# How the run ended:

print(result)

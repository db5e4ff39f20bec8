"""
Flyball governor
================

Benchmark A05 of IFToMM: stiff springs between the arms and a slider hold it up while the shaft
turns.
"""

# %%
# Declared in
# :download:`flyball_governor.py <../../../models/space/flyball_governor.py>`;
# at its start:

import linkwright as lw

machine = lw.load("space/flyball_governor", scene="run")
machine.draw()

# %%
# Its motion:

result = machine.simulate(10.0, method="radau5")
result.animate()

# %%
# Curves:

result.plot("slider.z", "shaft.omega_z")

# %%
# How the run ended:

print(result)

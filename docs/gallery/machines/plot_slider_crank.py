"""
The compressor of section 8.2
=============================
A crank, a rod and a slider that compresses gas.
"""

import matplotlib.pyplot as plt

import linkwright as lw

machine = lw.load("../../../models/slider_crank.py", scene="compressor")
result = machine.simulate(1.0)
result.plot("crank.omega")
plt.show()

"""Kinematics, inverse dynamics and simulation, and the quantities that they report."""

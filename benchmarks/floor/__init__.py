"""The floor: hand-reduced equations in an integrator that can do nothing else."""

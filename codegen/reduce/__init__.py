"""The reduced formulation: the equations of motion in fewer coordinates."""

"""Effects: potentials, applied forces and torques."""

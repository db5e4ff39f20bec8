"""Elements of machines in space."""

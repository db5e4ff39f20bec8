"""The tools that take a mechanism, on machines in space."""

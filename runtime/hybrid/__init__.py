"""Hybrid dynamics: switching functions, events, modes, sliding, stiction and impact."""

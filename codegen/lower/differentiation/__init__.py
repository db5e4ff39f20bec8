"""Derivatives of lowered values: gradients, directional derivatives, tangents."""

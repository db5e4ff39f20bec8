"""Joints: constraints between two bodies, or between a body and the ground."""

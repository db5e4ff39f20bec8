"""Checks of a declaration before it is compiled."""

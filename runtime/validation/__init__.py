"""Checks of arguments, parameters and scenes before an analysis."""

"""Equations derived by hand, as an expert with a week would write them: the bar to hold."""

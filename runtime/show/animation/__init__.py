"""Animations: a machine in motion with its curves, as one self-contained HTML page."""

"""Seeded campaigns of misuse: every answer is a sentence of ours, soon, or a right one."""

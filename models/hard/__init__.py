"""Machines that break multibody programs, and what each of them should do.

A file a machine, declared as those of `models` are; `cases` says what is asked of them,
``python -m models.hard`` asks it.
"""

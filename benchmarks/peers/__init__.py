"""Other tools on the same problems, each in its own file and its own process.

`python -m benchmarks.peers.NAME PROBLEM` solves a problem over a grid of settings and prints a line
of JSON for each point as soon as it has it, so that a run that is cut short keeps what it found.
"""

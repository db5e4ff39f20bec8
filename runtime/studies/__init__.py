"""Studies above the analyses: accuracy targets, work-precision diagrams, effect ranking."""

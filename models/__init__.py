"""The library of machines: one file a machine, each readable beside the book's figure."""

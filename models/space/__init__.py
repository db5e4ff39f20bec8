"""Machines in space, one file each; the mechanisms of Haug's chapter 12 among them."""

"""The ledger of a scene: what is in, what is out and why, and the cost of each part."""

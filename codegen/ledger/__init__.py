"""The ledger of a scene: what is in, what is out and why, and what each part of it costs."""

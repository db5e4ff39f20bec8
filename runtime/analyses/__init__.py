"""The engineer's questions, one file each."""

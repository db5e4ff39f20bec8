"""Studies: the questions that the book asks of its machines, answered and drawn."""

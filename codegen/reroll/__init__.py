"""Loop rerolling: the repetition in a kernel's values, as loops over tables of indices."""

"""Generated modules as files: paths, signatures, companions, atomic writing, machine code."""

"""Files: written whole or not at all, the library's own, and generated modules."""

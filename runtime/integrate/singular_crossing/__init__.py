"""Steps across singular configurations."""

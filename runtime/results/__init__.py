"""Results of analyses, and their files."""

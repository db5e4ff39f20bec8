"""Assembly: states that satisfy joints, drivers and start values."""

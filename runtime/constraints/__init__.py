"""Choice of independent coordinates and return of the others onto the constraints."""

"""Pictures of results; matplotlib is loaded only where one is drawn."""

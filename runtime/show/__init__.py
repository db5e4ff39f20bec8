"""Pictures, tables and pages of results; matplotlib is loaded only where a picture is drawn."""

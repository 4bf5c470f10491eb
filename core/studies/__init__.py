"""Studies: many runs, one statement about a method."""

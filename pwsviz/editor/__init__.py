"""A system of one's own: typed, checked, drawn."""

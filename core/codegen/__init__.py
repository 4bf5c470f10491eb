"""Generate the text of the functions that are compiled, from symbolic expressions."""

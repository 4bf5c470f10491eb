"""Checks of the arguments of public functions, and the display of their results."""

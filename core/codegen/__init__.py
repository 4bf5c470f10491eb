"""Expressions → text of the functions that are compiled."""

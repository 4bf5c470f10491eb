"""Sizes of windows at which the page changes."""

NARROW, LOW = 600, 480
"""Pixels of window width and height below which the controls start hidden, as they would cover or press the picture."""

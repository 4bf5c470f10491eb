"""Reusable parts of the page: fields, buttons, panes, progress."""

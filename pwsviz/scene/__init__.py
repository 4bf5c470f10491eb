"""The settings a user has chosen: their checks, their history, their link."""

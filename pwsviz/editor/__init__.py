"""The editor of a user's own system."""

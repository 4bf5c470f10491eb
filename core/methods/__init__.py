"""The integrators."""

"""Polylines at screen resolution, and the plane of the portrait."""

"""Polylines and planes: what is drawn of a curve, and where."""

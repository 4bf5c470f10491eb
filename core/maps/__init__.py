"""Poincaré sections, return maps and bifurcation diagrams: what many runs leave on a surface."""

from core.maps.section import Section, section
from core.maps.surface import own_surface
from core.maps.sweep import Sweep, sweep

__all__ = ["Section", "Sweep", "own_surface", "section", "sweep"]

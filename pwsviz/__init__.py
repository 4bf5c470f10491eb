"""The explorer: what a person sees of `core`.

Imports point one way: explorer → views → {scene, results} → core.
"""

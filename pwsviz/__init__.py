"""The explorer: a web page, a benchmark and a report built on `core`.

Imports point one way: page → tabs → figures → {results, scene} → core.
"""

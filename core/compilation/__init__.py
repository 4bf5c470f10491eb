"""Compile laws and methods, with caches in memory and on disk; worker processes that compile."""

"""Computations beside the page: only the latest request counts, and outdated ones are cancelled."""

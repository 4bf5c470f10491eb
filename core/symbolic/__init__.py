"""Expressions: the whitelist parser, proofs that they vanish, laws, the discrete gradient and multiplier."""

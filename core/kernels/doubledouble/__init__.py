"""Numbers of two doubles: some 32 digits, for levels of ψ and what round-off would take from them."""

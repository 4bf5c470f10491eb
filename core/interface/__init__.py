"""How the public functions take what a person gives, and how their results show themselves."""

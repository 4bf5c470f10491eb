"""Parts of a page that know nothing of what they are used for."""

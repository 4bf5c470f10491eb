"""Words and mathematics as they stand on the page."""

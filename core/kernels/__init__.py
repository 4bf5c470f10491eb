"""What compiled code calls: how it is called, divided differences, root isolation, Taylor coefficients."""

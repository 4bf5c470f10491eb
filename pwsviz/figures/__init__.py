"""The figures. Each is built once; afterwards only its data changes."""

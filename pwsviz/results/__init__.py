"""From a scene to arrays: what each picture depends on, and what was worked out for it."""

"""The paper's Algorithm 1: locate a crossing, land, classify it, switch to the next mode; and how runs end."""

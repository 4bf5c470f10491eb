"""The paper's Algorithm 1: locate a crossing, land, classify it, switch sides; and how runs end."""

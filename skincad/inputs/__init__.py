"""What a person writes: designs with the rules between their keys, processes, what ships, measured data."""

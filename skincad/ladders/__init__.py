"""What accuracy costs: ladders of models and settings, their error against their time, on any design."""

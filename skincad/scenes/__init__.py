"""Scenes: the march through a history, its signals, when ridges slip, and what is left out."""

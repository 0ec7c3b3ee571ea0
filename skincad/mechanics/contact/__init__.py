"""Contact with a rigid plate, with and without friction, of bodies that are linear at a state."""

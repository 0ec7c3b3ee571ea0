"""The exact section: curves, ridges and slots in the plane (x, z), mm."""

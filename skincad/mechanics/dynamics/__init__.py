"""Steps in time: masses, viscosity, and a plate with mass."""

"""The models of a check, from springs to the solid at finite strain, and what each costs."""

"""The films in their slots: what stress reaches them."""

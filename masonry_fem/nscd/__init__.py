"""The contact solver (non-smooth contact dynamics): arrays only."""

"""Contact points on an interface, one file a rule."""

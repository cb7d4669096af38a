"""Joint laws, one file a law."""

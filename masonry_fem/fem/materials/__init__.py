"""Material laws of inelastic stones, one file a law."""

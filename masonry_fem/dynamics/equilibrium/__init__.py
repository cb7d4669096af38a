"""Ways to come to rest, one file a strategy."""

"""What records are made of: quantities, and what structures need that knows nothing of a scene."""

"""What the machine gives: files that are written whole or not at all, and what is installed."""

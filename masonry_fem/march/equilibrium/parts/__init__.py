"""What strategies share, and marches that no scene asks for by name."""

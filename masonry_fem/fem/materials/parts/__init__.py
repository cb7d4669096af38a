"""What several material laws share."""

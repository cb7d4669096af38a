"""What a user describes: records, TOML in and out, checks."""

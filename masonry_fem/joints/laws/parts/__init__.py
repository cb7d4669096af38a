"""What laws derive from, and what a joint has besides its law: dry faces, roughness, a bed of mortar."""

"""What structures share: curves, bonds, grounds, rings. Files here are not searched for structures."""

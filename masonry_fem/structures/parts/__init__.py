"""What structures share: curves, bonds, grounds, rings; no structure stands here."""

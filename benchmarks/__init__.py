"""Benchmarks: what the program costs, beside what it must reach."""

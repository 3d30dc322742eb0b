"""Compiled recurrences: everything that runs once a sample."""

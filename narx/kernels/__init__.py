"""Compiled recurrences: everything that runs once per sample."""

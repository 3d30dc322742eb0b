"""Compiled recurrences: all code that runs once per sample."""

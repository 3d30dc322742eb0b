"""Runs of one or many sweeps in one table, and the report that shows them."""

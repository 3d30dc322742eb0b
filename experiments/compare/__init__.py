"""Compare the runs of one or several sweeps: one table, and a report."""

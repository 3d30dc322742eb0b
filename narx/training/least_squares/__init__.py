"""Least-squares problems of NARX networks, for `narx.training.least_squares.solver`."""

"""Least-squares problems of NARX networks, for `narx.levenberg_marquardt`."""

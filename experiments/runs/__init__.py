"""What every run leaves, how it is found again, and how a sweep of runs ends."""

"""What a benchmark says of its results: one module a paper, and one for everything else."""

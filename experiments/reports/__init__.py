"""Reports of a benchmark: one module per paper, and a generic one."""

"""Record of a run in its folder, its identity, and the end of a sweep."""

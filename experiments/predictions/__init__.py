"""What `narx-predict` reads and writes."""

"""Input and output of `narx-predict`."""

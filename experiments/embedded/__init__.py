"""What the methods cost on an 8-bit microcontroller, measured in a simulator."""

"""Simulated walking with known ground truth: skeleton, soft tissue, sensors and markers.

Steps of a simulated trial: `walker` (who walks, how) -> `gait_timing` (when the feet touch)
-> `gait_curves` (joint angles) -> `skeleton` (segments in space) -> `soft_tissue` -> `sensor`
and `markers` (what the instruments measure). `functional_movements` moves the same skeleton through
the calibration movements. Every parameter and its source is listed in docs/simulator.md.
"""

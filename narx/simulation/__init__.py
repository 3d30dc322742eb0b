"""Walking with known truth: skeleton, soft tissue, sensors and markers of virtual walkers.

The road of a simulated trial: `walker` (who walks, how) -> `gait_timing` (when the feet touch)
-> `gait_curves` (joint angles) -> `skeleton` (segments in space) -> `soft_tissue` -> `sensor`
and `markers` (what the instruments see). `functional_movements` gives the calibration movements
to the same skeleton. Every parameter and its source is listed in docs/simulator.md.
"""

"""Limits that the compiled kinematics and its forms in torch, numpy and C share."""

# smallest magnitude of the frontal angle's cosine: a segment lying sideways has no flexion axis
COS_FRONTAL_MIN = 0.1

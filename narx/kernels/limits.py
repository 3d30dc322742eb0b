"""Limits shared by the compiled kinematics and its versions in torch, numpy and C."""

# smallest magnitude of the frontal angle's cosine: a segment lying sideways has no flexion axis
COS_FRONTAL_MIN = 0.1

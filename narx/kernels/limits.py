"""Limits shared by the compiled kinematics and its versions in torch, numpy and C."""

# smallest magnitude of the frontal angle's cosine: a segment lying sideways has no flexion axis
COS_FRONTAL_MIN = 0.1
# no accelerometer worn on a leg measures more (200 g); beyond is a fault
FORCE_LIMIT_M_S2 = 2000.0
# a start pose beyond this many radians is a mistake, and huge ones would leave no digits
START_LIMIT_RAD = 1000.0

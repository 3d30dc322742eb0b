"""State, parameters and intermediate results of `narx.kernels.tracker` by index, and its limits."""

import math

# states of the filter; the last two only with an accelerometer
CENTRE, BIAS, LEAN, VELOCITY = 3, 6, 9, 10
GYROSCOPE_STATES, AIDED_STATES = 10, 12
# centre, bias and lean are constant from sample to sample
CONSTANT = VELOCITY - CENTRE

# further scalars: turn rate, swing and its turning points, timers, sums over the swing, rest
(
    TURN, SWING, HIGH, LOW, SPAN, RISING, SINCE, IDLE, PERIOD, TRUST, SCATTER, MISSING, SAMPLES,
) = range(13)  # fmt: skip
SUM_ANGLES, SUM_TURN, BEFORE, ODD, MEAN_RATE, KNOWN = 13, 16, 17, 19, 22, 25
# means of the square and the cube of the sagittal rate in walking
SQUARE, CUBE = 26, 27
# mean turn rate over a stride
TURNING = 28
# sum of the recent corrections of the two tilt angles, while the network propagates them
CORRECTED = 29
SCALARS = 31

# parameters; rates are per sample
(
    INTERVAL, LEAK, ANGLE_NOISE, RATE_NOISE, CENTRE_DECAY, CENTRE_NOISE, BIAS_NOISE,
    START_VARIANCE, KNOWN_ENOUGH, TURN_GAIN, TURN_LEAST, SWING_DECAY, SPAN_DECAY, SPAN_SHARE,
    SWING_LEAST, IDLE_MOST,
    RETURN_VARIANCE, PERIOD_SHARE, OUTLIER, EARLY, REST_GAIN, REST_LEAST, REST_VARIANCE,
    VELOCITY_NOISE, SPEED, RATE_SCALE, ANGLE_SCALE,
) = range(27)  # fmt: skip
CYCLE_VARIANCE, VELOCITY_VARIANCE, LEG_GAIN = 27, 30, 32
TURNING_GAIN, MOST_NET, REOPENED, DELAY_S, ALIGNMENT, CORRECTED_KEPT, PER_CORRECTED = range(33, 40)
PARAMETERS = 40

# rows of the intermediate results of a step: direction of a measurement and its product with the
# covariance, the network's output, gyroscope without bias, angles before corrections, changes of a
# sample, angles about which the network runs, their rates, means over a gap (two), and whether the
# sensor rests and whether a swing has ended
DIRECTION, PRODUCT, OUTPUT, OWN, CARRIED, CHANGE, ABOUT, NOW, MEANS = range(9)
EVENTS = MEANS + 2
WORK = EVENTS + 1
RESTS, SWUNG = 0, 1

SHORTEST_SWING_S, LONGEST_SWING_S = 0.5, 2.5
# a swing with more doubt, while the angle is known, is a change of posture such as sitting down
MOST_DOUBT = 50.0
# the network takes over along this last part of the limit on the variance of the posture
DOUBT_SPAN = 0.1
# once the posture is established, an angle so far from it is not that of a walking leg
NEAR_RAD, FAR_RAD = math.radians(45.0), math.radians(55.0)
# a longer gap leaves no more of the angle than this one
LONGEST_GAP_S = 1.0
# the motion is doubtful if the recent corrections add more to the standard deviation
MOST_CORRECTED_RAD = math.radians(5.0)
# larger than the bias of any current gyroscope
MOST_BIAS_RAD_S = math.radians(10.0)

/* ${title}: see the header. ISO C99, needs the standard math library alone. */
#include "${header}"

#include <math.h>
#include <string.h>

#define INTERVAL_S ${interval_s}
#define LEAK_RAD_S ${leak_rad_s}
#define SETTLING_GAIN ${settling_gain}
#define SETTLING_S ${settling_s}
#define AVERAGED_FROM_S ${averaged_from_s} /* of which the posture is the mean */
#define AVERAGING_S ${averaging_s}
#define MOVEMENT_TIME_CONSTANT_S ${movement_time_constant_s}
#define MOVEMENT_SQUARE ${movement_square}
#define PI ${pi}
#define WASHOUT_GAIN ${washout_gain} /* of the slow mean that is taken off */
#define SMALLEST_COS_FRONTAL ${smallest_cos_frontal}
#define COUPLED ${coupled} /* rates become those of the angles by the tilt so far */

#define HIDDEN ${hidden}
#define PAST_INPUTS ${past_inputs}
#define OUTPUT_LAGS ${output_lags}

static const narx_real RATE_OFFSET = ${rate_offset}, RATE_SCALE = ${rate_scale};
static const narx_real ANGLE_OFFSET = ${angle_offset}, ANGLE_SCALE = ${angle_scale};

/* columns: present and past inputs, past outputs, newest first */
static const narx_real W1[HIDDEN][NARX_NETWORK_STATE + 1] = {
${w1}
};
static const narx_real B1[HIDDEN] = {${b1}};
static const narx_real W2[HIDDEN] = {${w2}};
static const narx_real B2 = ${b2};

static void rates_of_angles(const narx_real axis_rates[3], const narx_real tilt[2],
                            narx_real rates[3])
{
#if COUPLED
    const narx_real sin_s = sin${f}(tilt[0]), cos_s = cos${f}(tilt[0]);
    const narx_real sin_f = sin${f}(tilt[1]);
    narx_real cos_f = cos${f}(tilt[1]);
    if (fabs${f}(cos_f) < SMALLEST_COS_FRONTAL)
        cos_f = cos_f < 0 ? -SMALLEST_COS_FRONTAL : SMALLEST_COS_FRONTAL;
    rates[2] = (axis_rates[2] * cos_s - axis_rates[1] * sin_s) / cos_f;
    rates[1] = axis_rates[1] * cos_s + axis_rates[2] * sin_s;
    rates[0] = axis_rates[0] - sin_f * rates[2];
#else
    (void)tilt;
    memcpy(rates, axis_rates, 3 * sizeof rates[0]);
#endif
}

static void hand_over(narx_state *state)
{
    int axis, k;
    for (axis = 0; axis < 3; axis++) {
        narx_real *const network = state->network[axis];
        const narx_real rate = state->rates[axis];
        narx_real deviation;
        if (state->known && state->posture_weight > 0)
            state->posture[axis] = state->posture_sum[axis] / state->posture_weight;
        deviation = state->angles[axis] - state->posture[axis];
        for (k = 0; k < PAST_INPUTS; k++)
            network[k] = (rate - RATE_OFFSET) / RATE_SCALE;
        network[PAST_INPUTS] = (deviation - ANGLE_OFFSET) / ANGLE_SCALE;
        for (k = 1; k < OUTPUT_LAGS; k++)
            network[PAST_INPUTS + k] = (deviation - INTERVAL_S * rate - ANGLE_OFFSET) / ANGLE_SCALE;
    }
}

/* Counts movement; returns the weight of this sample in the posture. */
static narx_real movement(narx_state *state, const narx_real axis_rates[3])
{
    const narx_real square = axis_rates[0] * axis_rates[0] + axis_rates[1] * axis_rates[1] +
                             axis_rates[2] * axis_rates[2];
    narx_real into, half;
    state->mean_square +=
        (square - state->mean_square) * INTERVAL_S / (MOVEMENT_TIME_CONSTANT_S + INTERVAL_S);
    if (state->mean_square > MOVEMENT_SQUARE)
        state->moving_left--;
    into = (narx_real)(NARX_MOVING_SAMPLES - state->moving_left) * INTERVAL_S;
    into -= AVERAGED_FROM_S;
    if (into <= 0 || into >= AVERAGING_S)
        return 0;
    half = sin${f}(PI * into / AVERAGING_S);
    return half * half;
}

static void start_up_step(narx_state *state, const narx_real axis_rates[3])
{
    const narx_real time_s = (narx_real)++state->samples * INTERVAL_S;
    const narx_real leak = LEAK_RAD_S + SETTLING_GAIN / (time_s + SETTLING_S);
    const narx_real damping = state->known ? 1 : 1 + INTERVAL_S * leak;
    const narx_real weight = movement(state, axis_rates);
    narx_real tilt[2], rates[3];
    int axis;
    for (axis = 0; axis < 2; axis++)
        tilt[axis] = state->angles[axis] + INTERVAL_S * state->rates[axis];
    rates_of_angles(axis_rates, tilt, rates);
    for (axis = 0; axis < 3; axis++) {
        const narx_real change = INTERVAL_S * (rates[axis] + state->rates[axis]) / 2;
        state->angles[axis] = (state->angles[axis] + change) / damping;
        state->rates[axis] = rates[axis];
        state->posture_sum[axis] += weight * state->angles[axis];
    }
    state->posture_weight += weight;
    if (state->moving_left == 0)
        hand_over(state);
}

static void network_step(narx_state *state, const narx_real axis_rates[3])
{
    narx_real tilt[2], rates[3];
    int axis, h, k;
    for (axis = 0; axis < 2; axis++) {
        const narx_real *const past = state->network[axis] + PAST_INPUTS;
        const narx_real next = OUTPUT_LAGS > 1 ? 2 * past[0] - past[OUTPUT_LAGS > 1] : past[0];
        tilt[axis] = next * ANGLE_SCALE + ANGLE_OFFSET + state->posture[axis];
    }
    rates_of_angles(axis_rates, tilt, rates);
    for (axis = 0; axis < 3; axis++) {
        narx_real *const network = state->network[axis];
        const narx_real input = (rates[axis] - RATE_OFFSET) / RATE_SCALE;
        narx_real output = B2;
        for (h = 0; h < HIDDEN; h++) {
            narx_real sum = B1[h] + W1[h][0] * input;
            for (k = 0; k < NARX_NETWORK_STATE; k++)
                sum += W1[h][k + 1] * network[k];
            output += W2[h] * tanh${f}(sum);
        }
        for (k = NARX_NETWORK_STATE - 1; k > 0; k--)
            network[k] = network[k - 1];
        if (PAST_INPUTS > 0)
            network[0] = input;
        network[PAST_INPUTS] = output;
        output = output * ANGLE_SCALE + ANGLE_OFFSET;
        state->mean[axis] += WASHOUT_GAIN * (output - state->mean[axis]);
        state->angles[axis] = output + state->posture[axis] - state->mean[axis];
    }
}

void narx_start(narx_state *state, const narx_real *initial_angles)
{
    memset(state, 0, sizeof *state);
    state->moving_left = NARX_MOVING_SAMPLES;
    if (initial_angles) {
        memcpy(state->angles, initial_angles, sizeof state->angles);
        state->known = 1;
    }
}

void narx_step(narx_state *state, const narx_real axis_rates[3], narx_real angles[3])
{
    int axis;
    for (axis = 0; axis < 3; axis++) {
        if (!isfinite(axis_rates[axis])) {
            angles[0] = angles[1] = angles[2] = NAN;
            return;
        }
    }
    if (state->moving_left > 0)
        start_up_step(state, axis_rates);
    else
        network_step(state, axis_rates);
    memcpy(angles, state->angles, sizeof state->angles);
}

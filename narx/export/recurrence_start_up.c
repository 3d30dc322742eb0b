#define LEAK_RAD_S ${leak_rad_s}
#define SETTLING_GAIN ${settling_gain}
#define SETTLING_S ${settling_s}
#define AVERAGED_FROM_S ${averaged_from_s} /* movement before the average for the posture begins */
#define AVERAGING_S ${averaging_s}
#define PI_PER_AVERAGING ${pi_per_averaging}
#define MOVEMENT_GAIN ${movement_gain}
#define MOVEMENT_SQUARE ${movement_square}
#define WASHOUT_GAIN ${washout_gain} /* of the slow mean that is subtracted */
#define COUPLED ${coupled} /* rates are converted to those of the angles with the estimated tilt */

#define HIDDEN ${hidden} /* identical neurons are merged */
#define PAST_INPUTS ${past_inputs}
#define OUTPUT_LAGS ${output_lags}
#define BIASES ${biases}

/* columns: present and past rates, past deviations, newest first; scales are in the weights */
static const narx_real W1[HIDDEN][NARX_NETWORK_STATE + 1] = {
${w1}
};
static const narx_real W2[HIDDEN] = {${w2}};
#if BIASES
static const narx_real B1[HIDDEN] = {${b1}};
static const narx_real B2 = ${b2};
#endif

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
            network[k] = rate;
        network[PAST_INPUTS] = deviation;
        for (k = 1; k < OUTPUT_LAGS; k++)
            network[PAST_INPUTS + k] = deviation - INTERVAL_S * rate;
    }
}

/* Counts samples in movement; returns the weight of this sample in the posture. */
static narx_real movement(narx_state *state, const narx_real axis_rates[3])
{
    const narx_real square = axis_rates[0] * axis_rates[0] + axis_rates[1] * axis_rates[1] +
                             axis_rates[2] * axis_rates[2];
    narx_real into, half;
    state->mean_square += (square - state->mean_square) * MOVEMENT_GAIN;
    if (state->mean_square > MOVEMENT_SQUARE)
        state->moving_left--;
    into = (narx_real)(NARX_MOVING_SAMPLES - state->moving_left) * INTERVAL_S;
    into -= AVERAGED_FROM_S;
    if (into <= 0 || into >= AVERAGING_S)
        return 0;
    half = sin${f}(into * PI_PER_AVERAGING);
    return half * half;
}

static void start_up_step(narx_state *state, const narx_real axis_rates[3])
{
    const narx_real weight = movement(state, axis_rates);
    narx_real kept = 1;
    narx_real rates[3] = {axis_rates[0], axis_rates[1], axis_rates[2]};
    int axis;
    state->samples++;
    if (!state->known) {
        const narx_real time_s = (narx_real)state->samples * INTERVAL_S;
        kept = 1 / (1 + INTERVAL_S * (LEAK_RAD_S + SETTLING_GAIN / (time_s + SETTLING_S)));
    }
#if COUPLED
    {
        narx_real tilt[2];
        for (axis = 0; axis < 2; axis++)
            tilt[axis] = state->angles[axis] + INTERVAL_S * state->rates[axis];
        rates_of_angles(axis_rates, tilt, rates);
    }
#endif
    for (axis = 0; axis < 3; axis++) {
        const narx_real change = HALF_INTERVAL_S * (rates[axis] + state->rates[axis]);
        state->angles[axis] = (state->angles[axis] + change) * kept;
        state->rates[axis] = rates[axis];
        state->posture_sum[axis] += weight * state->angles[axis];
    }
    state->posture_weight += weight;
    if (state->moving_left == 0)
        hand_over(state);
}

static void network_step(narx_state *state, const narx_real axis_rates[3])
{
    narx_real rates[3] = {axis_rates[0], axis_rates[1], axis_rates[2]};
    int axis, h, k;
#if COUPLED
    {
        narx_real tilt[2];
        for (axis = 0; axis < 2; axis++) {
            const narx_real *const past = state->network[axis] + PAST_INPUTS;
            const narx_real next = OUTPUT_LAGS > 1 ? past[0] + past[0] - past[OUTPUT_LAGS > 1] : past[0];
            tilt[axis] = next + state->posture[axis];
        }
        rates_of_angles(axis_rates, tilt, rates);
    }
#endif
    for (axis = 0; axis < 3; axis++) {
        narx_real *const network = state->network[axis];
        narx_real output = 0;
        for (h = 0; h < HIDDEN; h++) {
            narx_real sum = W1[h][0] * rates[axis];
            for (k = 0; k < NARX_NETWORK_STATE; k++)
                sum += W1[h][k + 1] * network[k];
#if BIASES
            sum += B1[h];
#endif
            output += W2[h] * hyperbolic_tangent(sum);
        }
#if BIASES
        output += B2;
#endif
        for (k = NARX_NETWORK_STATE - 1; k > 0; k--)
            network[k] = network[k - 1];
        if (PAST_INPUTS > 0)
            network[0] = rates[axis];
        network[PAST_INPUTS] = output;
        state->mean[axis] += WASHOUT_GAIN * (output - state->mean[axis]);
        state->angles[axis] = output + state->posture[axis] - state->mean[axis];
    }
}

static void advance(narx_state *state, const narx_real axis_rates[3])
{
    if (state->moving_left > 0)
        start_up_step(state, axis_rates);
    else
        network_step(state, axis_rates);
}

static void begin(narx_state *state, const narx_real *initial_angles)
{
    state->moving_left = NARX_MOVING_SAMPLES;
    state->known = initial_angles != NULL;
}

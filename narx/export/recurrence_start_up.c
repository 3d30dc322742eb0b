#define LEAK_RAD_S ${leak_rad_s}
#define SETTLING_GAIN ${settling_gain}
#define SETTLING_S ${settling_s}
#define AVERAGED_FROM_S ${averaged_from_s} /* movement before the average for the posture begins */
#define AVERAGING_S ${averaging_s}
#define PI_PER_AVERAGING ${pi_per_averaging}
#define MOVEMENT_GAIN ${movement_gain}
#define MOVEMENT_SQUARE ${movement_square}
#define WASHOUT_KEPT ${washout_kept} /* of an angle, from sample to sample */
#define WASHOUT_GAIN ${washout_gain} /* of the posture */
#define RATE_OFFSET_RAD_S ${rate_offset_rad_s}
#define ANGLE_OFFSET_RAD ${angle_offset_rad}
#define COUPLED ${coupled} /* rates are converted to those of the angles with the estimated tilt */

#define PAST_INPUTS ${past_inputs}
#define OUTPUT_LAGS ${output_lags}
#if COUPLED && NARX_AXES != 3
#error "the axes of this network are coupled: NARX_AXES is 3"
#endif

static void hand_over(narx_state *state)
{
    int axis, k;
    for (axis = 0; axis < NARX_AXES; axis++) {
        narx_real *const network = state->network[axis];
        const narx_real rate = state->rates[axis];
        narx_real deviation;
        if (state->known && state->posture_weight > 0)
            state->posture[axis] = state->posture_sum[axis] / state->posture_weight;
        deviation = state->angles[axis] - state->posture[axis];
        state->returning[axis] = WASHOUT_GAIN * state->posture[axis];
        for (k = 0; k < PAST_INPUTS; k++)
            network[k] = rate;
        network[PAST_INPUTS] = deviation;
        for (k = 1; k < OUTPUT_LAGS; k++)
            network[PAST_INPUTS + k] = deviation - INTERVAL_S * rate;
        state->next[axis] = state->angles[axis] + (OUTPUT_LAGS > 1 ? INTERVAL_S * rate : 0);
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
    for (axis = 0; axis < NARX_AXES; axis++) {
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
    int axis, k;
#if COUPLED
    narx_real rates[3];
    rates_of_angles(axis_rates, state->next, rates);
#else
    const narx_real *const rates = axis_rates;
#endif
    for (axis = 0; axis < NARX_AXES; axis++) {
        narx_real *const past_rates = state->network[axis];
        narx_real *const past = past_rates + PAST_INPUTS;
        const narx_real output = network_output(rates[axis], past_rates, past);
        const narx_real change = output - past[0];
        for (k = OUTPUT_LAGS - 1; k > 0; k--)
            past[k] = past[k - 1];
        past[0] = output;
#if PAST_INPUTS
        for (k = PAST_INPUTS - 1; k > 0; k--)
            past_rates[k] = past_rates[k - 1];
        past_rates[0] = rates[axis];
#endif
        /* the output less its slow mean, about the posture */
        state->angles[axis] = WASHOUT_KEPT * (state->angles[axis] + change) + state->returning[axis];
#if COUPLED
        if (axis < 2)
            state->next[axis] = state->posture[axis] + output + (OUTPUT_LAGS > 1 ? change : 0);
#endif
    }
}

static void advance(narx_state *state, const narx_real axis_rates[3])
{
    state->by_network = state->moving_left == 0;
    if (state->moving_left > 0)
        start_up_step(state, axis_rates);
    else
        network_step(state, axis_rates);
}

static void begin(narx_state *state, const narx_real *initial_angles)
{
    state->moving_left = NARX_MOVING_SAMPLES;
    state->known = initial_angles != NULL;
#if NARX_MOVING_SAMPLES == 0
    { /* the network starts from zero in its own units */
        int axis, k;
        memset(state->angles, 0, sizeof state->angles);
        for (axis = 0; axis < NARX_AXES; axis++) {
            for (k = 0; k < PAST_INPUTS; k++)
                state->network[axis][k] = RATE_OFFSET_RAD_S;
            for (k = 0; k < OUTPUT_LAGS; k++)
                state->network[axis][PAST_INPUTS + k] = ANGLE_OFFSET_RAD;
            state->angles[axis] = state->next[axis] = ANGLE_OFFSET_RAD;
        }
    }
#endif
}

/* Only a tracker recognises doubtful motion. */
static int is_doubtful(const narx_state *state)
{
    (void)state;
    return 0;
}

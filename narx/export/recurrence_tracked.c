#define N NARX_STATES
#define AIDED (NARX_INPUTS == 6)
enum { CENTRE = 3, BIAS = 6, LEAN = 9, VELOCITY = 10 };

#define PI ${pi}
#define HEADING_STEP 2
#define LONGEST_GAP_S ${longest_gap_s}
#define LONGEST_BRIDGED_S ${longest_bridged_s}
#define BRIDGED_RAD_S2 ${bridged_rad_s2}
#define SWING_TIME_S ${swing_time_s}
#define MOST_DOUBT ${most_doubt}
#define FAR_RAD ${far_rad}
#define PER_DOUBT ${per_doubt}
#define PER_FAR_RAD ${per_far_rad}
#define LEAK_RAD_S ${leak}
#define ANGLE_NOISE ${angle_noise}
#define RATE_NOISE ${rate_noise}
#define CENTRE_LOSS ${centre_loss} /* 1 - decay: a float close to one has few digits of it */
#define CENTRE_NOISE ${centre_noise}
#define BIAS_NOISE ${bias_noise}
#define START_VARIANCE ${start_variance}
#define KNOWN_ENOUGH ${known_enough}
#define TURN_GAIN ${turn_gain}
#define TURN_LEAST ${turn_least}
#define PER_TURN_LEAST ${per_turn_least}
#define SWING_GAIN_S ${swing_gain_s}
#define SWING_LOSS ${swing_loss}
#define SPAN_LOSS ${span_loss}
#define SPAN_SHARE ${span_share}
#define SWING_LEAST ${swing_least}
#define SHORTEST_SWING_S ${shortest_swing_s}
#define LONGEST_SWING_S ${longest_swing_s}
#define IDLE_MOST_S ${idle_most}
#define RETURN_VARIANCE ${return_variance}
#define PERIOD_SHARE ${period_share}
#define OUTLIER ${outlier}
#define EARLY ${early}
#define REST_GAIN ${rest_gain}
#define REST_LEAST ${rest_least}
#define REST_VARIANCE ${rest_variance}
#define MOST_BIAS_SQUARE ${most_bias_square}
#define LEG_GAIN ${leg_gain}
#define TURNING_GAIN ${turning_gain}
#define MOST_NET ${most_net}
#define REOPENED ${reopened}
#define DELAY_S ${delay_s}
#define ALIGNMENT ${alignment}
#define CORRECTED_KEPT ${corrected_kept}
#define PER_CORRECTED ${per_corrected}
#define MOST_CORRECTED_RAD ${most_corrected}
#define LEG_SKEWNESS ${leg_skewness}
#define STD_GROWTH ${std_growth}
#define MOST_GROWTH ${most_growth}
#define DOUBTFUL_GROWTH ${doubtful_growth}
#define START_SQUARE ${start_square}
#define VELOCITY_NOISE ${velocity_noise}
#define SPEED ${speed}

static const narx_real CYCLE_VARIANCE[3] = {${cycle_variance}};
#if AIDED
static const narx_real VELOCITY_VARIANCE[2] = {${velocity_variance}};
#endif
static const narx_real STD_SCALE[3] = {${std_scale}};
static const narx_real X_START[N] = {${x_start}};
static const narx_real UNKNOWN_VARIANCE[N] = {${unknown_variance}};
static const narx_real KNOWN_VARIANCE[N] = {${known_variance}};

static narx_real squared(narx_real value)
{
    return value * value;
}

${covariance}
static narx_real network(const narx_state *s, int axis, narx_real rate, narx_real about)
{
    narx_real past[NARX_PAST_ANGLES];
    int k;
    for (k = 0; k < NARX_PAST_ANGLES; k++)
        past[k] = s->past[axis][k] - about;
    return (NETWORK_BY_CHANGE ? s->past[axis][0] : about) +
           network_output(rate, s->rates[axis], past);
}

static narx_real larger(narx_real a, narx_real b)
{
    return a < b ? b : a;
}

static narx_real limited(narx_real share)
{
    return share < 0 ? 0 : share > 1 ? 1 : share;
}

/* Returns the network's share in the propagation of the angles, 0 to 1. It falls along a line as the
   posture becomes uncertain, and far from an established one: a threshold would amplify rounding
   errors. */
static narx_real share_of_network(const narx_state *s)
{
    const narx_real doubt =
        larger(s->covariance[CENTRE][CENTRE], s->covariance[CENTRE + 1][CENTRE + 1]);
    const narx_real away =
        larger(fabs${f}(s->x[0] - s->x[CENTRE]), fabs${f}(s->x[1] - s->x[CENTRE + 1]));
    const narx_real near = s->trust > EARLY ? limited((FAR_RAD - away) * PER_FAR_RAD) : 1;
    return s->idle_s < IDLE_MOST_S ? limited((KNOWN_ENOUGH - doubt) * PER_DOUBT) * near : 0;
}

/* Propagates the angles over one sample; returns the turn rate. */
static narx_real carry(narx_state *s, const narx_real own[3], narx_real share, narx_real *secant)
{
    narx_real tilt[2], rates[3];
    int axis, k;
    for (axis = 0; axis < 2; axis++) {
        const narx_real *const past = s->past[axis];
        tilt[axis] =
            NARX_PAST_ANGLES > 1 ? past[0] + past[0] - past[NARX_PAST_ANGLES > 1] : past[0];
    }
    *secant = rates_of_angles(own, tilt, rates);
    s->turn += TURN_GAIN * (rates[2] - s->turn);
    for (axis = 0; axis < 3; axis++) {
        const narx_real lean = axis == 1 ? s->x[LEAN] * s->turn : 0;
        const narx_real moved = HALF_INTERVAL_S * (rates[axis] + s->rates[axis][0]);
        const narx_real integrated = s->past[axis][0] + moved;
        if (share > 0)
            s->x[axis] = network(s, axis, rates[axis], s->x[CENTRE + axis] + lean);
        if (share < 1)
            s->x[axis] = integrated + (share > 0 ? share * (s->x[axis] - integrated) : 0);
        if (axis < 2)
            s->corrected[axis] = CORRECTED_KEPT * s->corrected[axis] + (s->x[axis] - integrated);
        for (k = NARX_PAST_RATES - 1; k > 0; k--)
            s->rates[axis][k] = s->rates[axis][k - 1];
        s->rates[axis][0] = rates[axis];
    }
    return rates[2];
}

/* Tracks the swing of the leg; true at the sample where the end of a forward swing is detected. */
static int swing_ends(narx_state *s, narx_real own_sagittal)
{
    narx_real least;
    s->swing += SWING_GAIN_S * own_sagittal - SWING_LOSS * s->swing;
    s->high = s->swing > s->high ? s->swing : s->high;
    s->low = s->swing < s->low ? s->swing : s->low;
    s->span -= SPAN_LOSS * s->span;
    least = SPAN_SHARE * s->span > SWING_LEAST ? SPAN_SHARE * s->span : SWING_LEAST;
    if (!s->rising && s->swing - s->low > least) {
        s->rising = 1;
        s->high = s->swing;
    }
    if (!s->rising || s->high - s->swing <= least)
        return 0;
    if (s->high - s->low > s->span)
        s->span = s->high - s->low;
    s->rising = 0;
    s->low = s->swing;
    return 1;
}

/* Updates the posture by the mean angle of a swing, with more weight the more it is like gait;
 * true if the leg walks. */
static int learn_from_swing(narx_state *s)
{
    const narx_real turn = s->sum_turn / s->samples;
    const narx_real net = squared(s->x[0] - s->before[0]) + squared(s->x[1] - s->before[1]);
    narx_real doubt = 1 + net / RETURN_VARIANCE;
    int axis, walks;
    doubt += s->period_s > 0 ? squared((s->swing_s / s->period_s - 1) / PERIOD_SHARE) : 3;
    if (fabs${f}(turn) > TURN_LEAST)
        widen_posture(s, 2, squared(turn * s->swing_s));
    if (net > MOST_NET && !s->known)
        for (axis = 0; axis < 2; axis++)
            s->covariance[axis][axis] += REOPENED;
    walks = doubt < MOST_DOUBT || s->covariance[0][0] > KNOWN_ENOUGH ||
            s->covariance[1][1] > KNOWN_ENOUGH;
    for (axis = 0; axis < 3; axis++) {
        const narx_real variance = CYCLE_VARIANCE[axis] * doubt, lean = axis == 1 ? -turn : 0;
        narx_real spread[N], residual, excess;
        residual = s->x[CENTRE + axis] - s->sum_angles[axis] / s->samples;
        residual -= s->x[LEAN] * lean;
        excess = squared(residual) / (OUTLIER * (spread_of(s, axis, lean, spread) + variance));
        if (excess <= 1) {
            s->odd[axis] = 0;
        } else if (s->odd[axis] * residual > 0) {
            /* a heading far from the mean is a turn, never an error */
            const narx_real share = axis < 2 ? squared(EARLY / (EARLY + s->trust)) : 0;
            s->covariance[axis][axis] += squared(residual) * share;
            widen_posture(s, axis, squared(residual) * (1 - share));
            s->odd[axis] = 0;
        } else {
            s->odd[axis] = residual < 0 ? -1 : 1;
            continue;
        }
        {
            const narx_real total = spread_of(s, axis, lean, spread) + variance;
            update(s, spread, total, residual);
        }
    }
    s->trust += 1 / doubt;
    return walks && !(fabs${f}(s->odd[0]) + fabs${f}(s->odd[1]) > 0);
}

/* Keeps the heading small, so that no digits are lost after many turns; the step is exact. */
static void shift_heading(narx_state *s, narx_real step)
{
    int k;
    s->x[2] -= step;
    s->x[CENTRE + 2] -= step;
    for (k = 0; k < NARX_PAST_ANGLES; k++)
        s->past[2][k] -= step;
    s->sum_angles[2] -= s->samples * step;
    s->heading += step;
}

/* Adds a small change to the value; the rounding error is kept for the next call. */
static void add_small(narx_real *value, narx_real *lower, narx_real change)
{
    const narx_real whole = *lower + change, sum = *value + whole;
    *lower = whole - (sum - *value);
    *value = sum;
}

/* Interpolates the rates linearly over a short gap, up to the sample before the present one. */
static void bridge(narx_state *s, const narx_real own[3])
{
    const narx_real gap = s->missing_s, whole = gap + INTERVAL_S, lost = gap / INTERVAL_S;
    const narx_real tilt[2] = {s->past[0][0], s->past[1][0]}, before = s->rates[0][0];
    const narx_real kept = exp${f}(-gap / SWING_TIME_S);
    narx_real now[3];
    int axis, k;
    rates_of_angles(own, tilt, now);
    for (axis = 0; axis < 3; axis++) {
        const narx_real last = s->rates[axis][0], begin = s->past[axis][0];
        const narx_real slope = (now[axis] - last) / whole;
        s->sum_angles[axis] += lost * (begin + whole / 2 * (last + slope * (whole + gap) / 6));
        if (axis == 2)
            s->sum_turn += lost * (last + whole / 2 * slope);
        for (k = 0; k < NARX_PAST_ANGLES; k++) {
            const narx_real at = gap - (narx_real)k * INTERVAL_S;
            s->past[axis][k] = begin + at * (last + slope / 2 * at);
        }
        for (k = 0; k < NARX_PAST_RATES; k++)
            s->rates[axis][k] = last + slope * (gap - (narx_real)k * INTERVAL_S);
        s->x[axis] = s->past[axis][0];
        s->covariance[axis][axis] += squared(BRIDGED_RAD_S2 * squared(gap));
    }
    s->swing = kept * s->swing + (1 - kept) * SWING_TIME_S * (before + s->rates[0][0]) / 2;
    s->samples += lost;
    s->swing_s += gap;
    s->idle_s += gap;
    s->missing_s = 0;
}

static void lose_track(narx_state *s)
{
    const narx_real whole = s->missing_s < LONGEST_GAP_S ? s->missing_s : LONGEST_GAP_S;
    int axis;
    for (axis = 0; axis < 3; axis++) {
        s->covariance[axis][axis] += START_VARIANCE * squared(whole);
        s->sum_angles[axis] = 0;
    }
    s->missing_s = s->swing = s->high = s->low = 0;
    s->swing_s = s->period_s = s->samples = s->sum_turn = 0;
    s->rising = 0;
    s->idle_s = IDLE_MOST_S;
}

static void advance(narx_state *s, const narx_real inputs[NARX_INPUTS])
{
    const narx_real loss = s->known ? 0 : CENTRE_LOSS;
    narx_real own[3], carried[3], scatter = 0, rates = 0, means = 0, secant, turn, turned;
    narx_real share, leak, coupling, noise, posture[2];
    change_type change;
    const int bridged = s->missing_s > 0 && s->missing_s < LONGEST_BRIDGED_S;
    int axis, k;
    if (s->missing_s > 0 && !bridged)
        lose_track(s);
    for (axis = 0; axis < 3; axis++) {
        const narx_real away = inputs[axis] - s->mean_rate[axis];
        own[axis] = inputs[axis] - s->x[BIAS + axis];
        rates += squared(own[axis]);
        s->mean_rate[axis] += REST_GAIN * away;
        scatter += squared(away);
        means += squared(s->mean_rate[axis]);
    }
    s->scatter += REST_GAIN * (scatter - s->scatter);
    if (bridged)
        bridge(s, own);
    if (s->idle_s < IDLE_MOST_S) {
        s->square += LEG_GAIN * (squared(own[0]) - s->square);
        s->cube += LEG_GAIN * (squared(own[0]) * own[0] - s->cube);
    }
    share = share_of_network(s);
    s->by_network = share > 0;
    turn = carry(s, own, share, &secant);
    if (fabs${f}(s->x[0]) > PI) {
        const narx_real whole = s->x[0] < 0 ? -2 * PI : 2 * PI;
        s->x[0] -= whole;
        for (k = 0; k < NARX_PAST_ANGLES; k++)
            s->past[0][k] -= whole;
    }
    if (fabs${f}(s->x[2]) > HEADING_STEP)
        shift_heading(s, s->x[2] < 0 ? -HEADING_STEP : HEADING_STEP);
    memcpy(carried, s->x, sizeof carried);
    leak = share * (LEAK_RAD_S * INTERVAL_S);
    /* over a stride the leg's own rotation has no mean, so that what remains is a turn */
    s->turning += TURNING_GAIN * (turn - s->turning);
    coupling = fabs${f}(s->turning) > TURN_LEAST ? INTERVAL_S * s->turn : 0;
    /* the mean heading turns with the person; a threshold would amplify rounding errors */
    turned = limited(fabs${f}(s->turning) * PER_TURN_LEAST - 1);
    s->x[CENTRE + 2] += INTERVAL_S * s->turn * turned;
    memset(&change, 0, sizeof change);
    for (axis = 0; axis < 3; axis++) {
        put(&change, axis, axis, -leak);
        put(&change, axis, BIAS + axis, -INTERVAL_S);
    }
    for (axis = 0; axis < 2; axis++)
        add_small(&s->x[CENTRE + axis], &s->lower[axis], -loss * s->x[CENTRE + axis]);
    for (k = 0; k <= CENTRE; k += CENTRE) {
        put(&change, 0, k + 1, -coupling);
        put(&change, 1, k, coupling);
    }
    put(&change, 1, LEAN, leak * s->turn);
#if AIDED
    {
        const narx_real *const force = inputs + 3;
        const narx_real ahead = s->x[VELOCITY], aside = s->x[VELOCITY + 1];
        narx_real sin_s, cos_s, sin_f, cos_ff, up, forward, left;
        sine_cosine(s->x[0], &sin_s, &cos_s);
        sine_cosine(s->x[1], &sin_f, &cos_ff);
        up = sin_s * force[0] + cos_s * force[2];
        forward = cos_s * force[0] - sin_s * force[2];
        left = cos_ff * force[1] + sin_f * up;
        s->x[VELOCITY] += INTERVAL_S * (forward + turn * aside);
        s->x[VELOCITY + 1] += INTERVAL_S * (left - turn * ahead);
        for (k = 0; k <= CENTRE; k += CENTRE) {
            put(&change, 3, k, -INTERVAL_S * up);
            put(&change, 4, k + 1, INTERVAL_S * (cos_ff * up - sin_f * force[1]));
        }
        put(&change, 3, VELOCITY + 1, INTERVAL_S * turn);
        put(&change, 4, VELOCITY, -INTERVAL_S * turn);
    }
#endif
    for (axis = 0; axis < 2; axis++)
        posture[axis] = s->covariance[CENTRE + axis][CENTRE + axis];
    propagate(s, &change, loss);
    noise = s->known ? 0 : CENTRE_NOISE;
    for (axis = 0; axis < 3; axis++) {
        s->covariance[axis][axis] += ANGLE_NOISE + RATE_NOISE * rates * squared(secant);
        s->covariance[BIAS + axis][BIAS + axis] += BIAS_NOISE;
    }
    for (axis = 0; axis < 2; axis++) {
        widen_posture(s, axis, noise);
        /* it crosses KNOWN_ENOUGH slowly: rounding would change the sample at which it does */
        s->covariance[CENTRE + axis][CENTRE + axis] = posture[axis];
        add_small(&s->covariance[CENTRE + axis][CENTRE + axis], &s->lower[2 + axis],
                  noise - loss * (2 - loss) * posture[axis]);
    }
    for (k = VELOCITY; k < N; k++)
        s->covariance[k][k] += VELOCITY_NOISE;
    if (s->scatter < REST_LEAST && means < MOST_BIAS_SQUARE)
        for (axis = 0; axis < 3; axis++)
            measure_state(s, BIAS + axis, REST_VARIANCE, s->mean_rate[axis] - s->x[BIAS + axis]);
    s->swing_s += INTERVAL_S;
    s->idle_s += INTERVAL_S;
    s->samples += 1;
    s->sum_turn += turn;
    for (axis = 0; axis < 3; axis++)
        s->sum_angles[axis] += carried[axis];
#if AIDED
    measure_state(s, VELOCITY, VELOCITY_VARIANCE[0], SPEED - s->x[VELOCITY]);
    measure_state(s, VELOCITY + 1, VELOCITY_VARIANCE[1], -s->x[VELOCITY + 1]);
#endif
    if (swing_ends(s, own[0])) {
        const int swung = s->swing_s > SHORTEST_SWING_S && s->swing_s < LONGEST_SWING_S;
        if (swung && learn_from_swing(s))
            s->idle_s = 0;
        s->period_s = swung ? s->swing_s : 0;
        s->swing_s = s->samples = s->sum_turn = 0;
        memset(s->sum_angles, 0, sizeof s->sum_angles);
        memcpy(s->before, s->x, sizeof s->before);
    }
    for (axis = 0; axis < 3; axis++) {
        const narx_real correction = s->x[axis] - carried[axis];
        if (axis < 2)
            s->corrected[axis] += share * correction;
        for (k = NARX_PAST_ANGLES - 1; k > 0; k--)
            s->past[axis][k] = s->past[axis][k - 1] + correction;
        s->past[axis][0] = s->x[axis];
    }
    memcpy(s->angles, s->x, sizeof s->angles);
    s->angles[2] += s->heading;
}

static void lose(narx_state *s, int ticks)
{
    s->missing_s += (narx_real)ticks * INTERVAL_S;
}

static void begin(narx_state *state, const narx_real *initial_angles)
{
    int i, k;
    memcpy(state->x, X_START, sizeof state->x);
    state->known = initial_angles != NULL;
    for (i = 0; i < N; i++)
        state->covariance[i][i] = state->known ? KNOWN_VARIANCE[i] : UNKNOWN_VARIANCE[i];
    for (i = 0; i < 3; i++) {
        const narx_real posture = state->covariance[CENTRE + i][CENTRE + i];
        state->covariance[CENTRE + i][CENTRE + i] = 0;
        widen_posture(state, i, posture);
        state->x[i] = state->angles[i];
        for (k = 0; k < NARX_PAST_ANGLES; k++)
            state->past[i][k] = state->angles[i];
    }
    state->scatter = 1;
    state->square = START_SQUARE;
    state->cube = state->known ? LEG_SKEWNESS * START_SQUARE * sqrt${f}(START_SQUARE) : 0;
    state->idle_s = IDLE_MOST_S;
    /* the swing in which a recording begins is not complete */
    state->swing_s = LONGEST_SWING_S;
}

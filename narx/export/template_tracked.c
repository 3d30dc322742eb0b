/* ${title}: see the header. ISO C99, needs the standard math library alone. */
#include "${header}"

#include <math.h>
#include <string.h>

#define N NARX_STATES
#define AIDED (NARX_INPUTS == 6)
enum { CENTRE = 3, BIAS = 6, LEAN = 9, VELOCITY = 10 };

#define PI ${pi}
#define INTERVAL_S ${interval}
#define LEAK_RAD_S ${leak}
#define ANGLE_NOISE ${angle_noise}
#define RATE_NOISE ${rate_noise}
#define CENTRE_DECAY ${centre_decay}
#define CENTRE_NOISE ${centre_noise}
#define BIAS_NOISE ${bias_noise}
#define START_VARIANCE ${start_variance}
#define KNOWN_ENOUGH ${known_enough}
#define TURN_GAIN ${turn_gain}
#define TURN_LEAST ${turn_least}
#define SWING_DECAY ${swing_decay}
#define SPAN_DECAY ${span_decay}
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
#define VELOCITY_NOISE ${velocity_noise}
#define SPEED ${speed}
#define RATE_SCALE ${rate_scale}
#define ANGLE_SCALE ${angle_scale}
#define SMALLEST_COS_FRONTAL ${smallest_cos_frontal}

#define HIDDEN ${hidden}
#define PAST_INPUTS ${past_inputs}

static const narx_real CYCLE_VARIANCE[3] = {${cycle_variance}};
#if AIDED
static const narx_real VELOCITY_VARIANCE[2] = {${velocity_variance}};
#endif
static const narx_real STD_SCALE[3] = {${std_scale}};
static const narx_real X_START[N] = {${x_start}};
static const narx_real UNKNOWN_VARIANCE[N] = {${unknown_variance}};
static const narx_real KNOWN_VARIANCE[N] = {${known_variance}};

/* columns: present and past inputs, past outputs, newest first */
static const narx_real W1[HIDDEN][1 + PAST_INPUTS + NARX_PAST_ANGLES] = {
${w1}
};
static const narx_real B1[HIDDEN] = {${b1}};
static const narx_real W2[HIDDEN] = {${w2}};
static const narx_real B2 = ${b2};

static narx_real square(narx_real value)
{
    return value * value;
}

/* Covariance times direction; returns the variance of direction . x. */
static narx_real spread_of(const narx_state *s, const narx_real direction[N], narx_real spread[N])
{
    narx_real total = 0;
    int i, j;
    memset(spread, 0, N * sizeof spread[0]);
    for (i = 0; i < N; i++)
        if (direction[i] < 0 || direction[i] > 0)
            for (j = 0; j < N; j++)
                spread[j] += direction[i] * s->covariance[i][j];
    for (i = 0; i < N; i++)
        total += spread[i] * direction[i];
    return total;
}

/* Kalman update by one number: residual = measured - direction . x. */
static void measure(narx_state *s, const narx_real direction[N], narx_real variance,
                    narx_real residual)
{
    narx_real spread[N];
    const narx_real total = spread_of(s, direction, spread) + variance;
    int i, j;
    for (i = 0; i < N; i++) {
        const narx_real gain = spread[i] / total;
        s->x[i] += gain * residual;
        for (j = 0; j < N; j++)
            s->covariance[i][j] -= gain * spread[j];
    }
}

static void measure_state(narx_state *s, int at, narx_real variance, narx_real residual)
{
    narx_real direction[N];
    memset(direction, 0, sizeof direction);
    direction[at] = 1;
    measure(s, direction, variance, residual);
}

/* Carries the covariance over one sample: x <- (1 + change) x, two centres times decay. */
static void propagate(narx_state *s, const narx_real change[5][N], narx_real decay)
{
    static const int ROW[5] = {0, 1, 2, VELOCITY, VELOCITY + 1};
    const int rows = AIDED ? 5 : 3;
    narx_real moved[5][N];
    int i, j, k;
    for (i = CENTRE; i < CENTRE + 2; i++) {
        for (j = 0; j < N; j++)
            s->covariance[i][j] *= decay;
        for (j = 0; j < N; j++)
            s->covariance[j][i] *= decay;
    }
    memset(moved, 0, sizeof moved);
    for (i = 0; i < rows; i++)
        for (k = 0; k < N; k++)
            if (change[i][k] < 0 || change[i][k] > 0)
                for (j = 0; j < N; j++)
                    moved[i][j] += change[i][k] * s->covariance[k][j];
    for (i = 0; i < rows; i++) {
        for (j = 0; j < N; j++) {
            s->covariance[ROW[i]][j] += moved[i][j];
            s->covariance[j][ROW[i]] += moved[i][j];
        }
        for (j = 0; j < rows; j++)
            for (k = 0; k < N; k++)
                s->covariance[ROW[i]][ROW[j]] += moved[i][k] * change[j][k];
    }
}

static narx_real network(const narx_state *s, int axis, narx_real rate, narx_real about)
{
    narx_real output = B2;
    int h, k;
    for (h = 0; h < HIDDEN; h++) {
        narx_real sum = B1[h] + W1[h][0] * (rate / RATE_SCALE);
        for (k = 0; k < PAST_INPUTS; k++)
            sum += W1[h][1 + k] * (s->rates[axis][k] / RATE_SCALE);
        for (k = 0; k < NARX_PAST_ANGLES; k++)
            sum += W1[h][1 + PAST_INPUTS + k] * ((s->past[axis][k] - about) / ANGLE_SCALE);
        output += W2[h] * tanh${f}(sum);
    }
    return output * ANGLE_SCALE + about;
}

/* Carries the angles over one sample; returns the turn rate. */
static narx_real advance(narx_state *s, const narx_real own[3], narx_real *cos_frontal)
{
    narx_real tilt[2], rates[3];
    int axis, k;
    for (axis = 0; axis < 2; axis++) {
        const narx_real *const past = s->past[axis];
        tilt[axis] =
            NARX_PAST_ANGLES > 1 ? 2 * past[0] - past[NARX_PAST_ANGLES > 1] : past[0];
    }
    {
        const narx_real sin_s = sin${f}(tilt[0]), cos_s = cos${f}(tilt[0]);
        narx_real cos_f = cos${f}(tilt[1]);
        if (fabs${f}(cos_f) < SMALLEST_COS_FRONTAL)
            cos_f = cos_f < 0 ? -SMALLEST_COS_FRONTAL : SMALLEST_COS_FRONTAL;
        rates[2] = (own[2] * cos_s - own[1] * sin_s) / cos_f;
        rates[1] = own[1] * cos_s + own[2] * sin_s;
        rates[0] = own[0] - sin${f}(tilt[1]) * rates[2];
        *cos_frontal = cos_f;
    }
    s->turn += TURN_GAIN * (rates[2] - s->turn);
    for (axis = 0; axis < 3; axis++) {
        const narx_real lean = axis == 1 ? s->x[LEAN] * s->turn : 0;
        s->x[axis] = s->by_network
                         ? network(s, axis, rates[axis], s->x[CENTRE + axis] + lean)
                         : s->past[axis][0] + INTERVAL_S * (rates[axis] + s->rates[axis][0]) / 2;
        for (k = NARX_PAST_RATES - 1; k > 0; k--)
            s->rates[axis][k] = s->rates[axis][k - 1];
        s->rates[axis][0] = rates[axis];
    }
    return rates[2];
}

/* Follows the swing of the leg; true where a forward swing has just been turned round. */
static int swing_ends(narx_state *s, narx_real own_sagittal)
{
    narx_real least;
    s->swing = (s->swing + INTERVAL_S * own_sagittal) / SWING_DECAY;
    s->high = s->swing > s->high ? s->swing : s->high;
    s->low = s->swing < s->low ? s->swing : s->low;
    s->span *= SPAN_DECAY;
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

/* A swing's mean angle is the posture's, more so the more it is like gait. */
static void learn_from_swing(narx_state *s)
{
    const narx_real turn = s->sum_turn / s->samples;
    narx_real doubt = 1 + (square(s->x[0] - s->before[0]) + square(s->x[1] - s->before[1])) /
                              RETURN_VARIANCE;
    int axis;
    doubt += s->period_s > 0 ? square((s->since_s / s->period_s - 1) / PERIOD_SHARE) : 3;
    if (fabs${f}(turn) > TURN_LEAST)
        s->covariance[CENTRE + 2][CENTRE + 2] += square(turn * s->since_s);
    for (axis = 0; axis < 3; axis++) {
        narx_real direction[N], spread[N], residual, excess;
        const narx_real variance = CYCLE_VARIANCE[axis] * doubt;
        memset(direction, 0, sizeof direction);
        direction[axis] = 1;
        direction[CENTRE + axis] = -1;
        residual = s->x[CENTRE + axis] - s->sum_angles[axis] / s->samples;
        if (axis == 1) {
            direction[LEAN] = -turn;
            residual += s->x[LEAN] * turn;
        }
        excess = square(residual) / (OUTLIER * (spread_of(s, direction, spread) + variance));
        if (excess <= 1) {
            s->odd[axis] = 0;
        } else if (s->odd[axis] * residual > 0) {
            const narx_real share = EARLY / (EARLY + s->trust);
            s->covariance[axis][axis] += square(residual) * share;
            s->covariance[CENTRE + axis][CENTRE + axis] += square(residual) * (1 - share);
            s->odd[axis] = 0;
        } else {
            s->odd[axis] = residual < 0 ? -1 : 1;
            continue;
        }
        measure(s, direction, variance, residual);
    }
    s->trust += 1 / doubt;
}

static void after_gap(narx_state *s)
{
    const narx_real whole = s->missing_s < 1 ? s->missing_s : 1;
    int axis;
    for (axis = 0; axis < 3; axis++) {
        s->covariance[axis][axis] += START_VARIANCE * square(whole);
        s->sum_angles[axis] = 0;
    }
    s->missing_s = s->swing = s->high = s->low = 0;
    s->since_s = s->period_s = s->samples = s->sum_turn = 0;
    s->rising = 0;
    s->idle_s = IDLE_MOST_S;
}

static void estimate(narx_state *s, const narx_real inputs[NARX_INPUTS])
{
    const narx_real decay = s->known ? 1 : CENTRE_DECAY;
    narx_real own[3], carried[3], change[5][N], scatter = 0, rates = 0, means = 0, cos_f, turn;
    narx_real leak, coupling, noise;
    int axis, k;
    if (s->missing_s > 0)
        after_gap(s);
    for (axis = 0; axis < 3; axis++) {
        const narx_real away = inputs[axis] - s->mean_rate[axis];
        own[axis] = inputs[axis] - s->x[BIAS + axis];
        rates += square(own[axis]);
        s->mean_rate[axis] += REST_GAIN * away;
        scatter += square(away);
        means += square(s->mean_rate[axis]);
    }
    s->scatter += REST_GAIN * (scatter - s->scatter);
    s->by_network = s->idle_s < IDLE_MOST_S && s->covariance[CENTRE][CENTRE] < KNOWN_ENOUGH &&
                    s->covariance[CENTRE + 1][CENTRE + 1] < KNOWN_ENOUGH;
    turn = advance(s, own, &cos_f);
    if (fabs${f}(s->x[0]) > PI) {
        const narx_real whole = s->x[0] < 0 ? -2 * PI : 2 * PI;
        s->x[0] -= whole;
        for (k = 0; k < NARX_PAST_ANGLES; k++)
            s->past[0][k] -= whole;
    }
    memcpy(carried, s->x, sizeof carried);
    leak = s->by_network ? LEAK_RAD_S * INTERVAL_S : 0;
    coupling = fabs${f}(s->turn) > TURN_LEAST ? INTERVAL_S * s->turn : 0;
    memset(change, 0, sizeof change);
    for (axis = 0; axis < 3; axis++) {
        change[axis][axis] = -leak;
        change[axis][CENTRE + axis] = leak;
        change[axis][BIAS + axis] = -INTERVAL_S;
    }
    for (axis = 0; axis < 2; axis++)
        s->x[CENTRE + axis] *= decay;
    change[0][1] = -coupling;
    change[1][0] = coupling;
    change[1][LEAN] = leak * s->turn;
#if AIDED
    {
        const narx_real *const force = inputs + 3;
        const narx_real sin_s = sin${f}(s->x[0]), cos_s = cos${f}(s->x[0]);
        const narx_real sin_f = sin${f}(s->x[1]), cos_ff = cos${f}(s->x[1]);
        const narx_real up = sin_s * force[0] + cos_s * force[2];
        const narx_real ahead = s->x[VELOCITY], aside = s->x[VELOCITY + 1];
        const narx_real forward = cos_s * force[0] - sin_s * force[2];
        const narx_real left = cos_ff * force[1] + sin_f * up;
        s->x[VELOCITY] += INTERVAL_S * (forward + turn * aside);
        s->x[VELOCITY + 1] += INTERVAL_S * (left - turn * ahead);
        change[3][0] = -INTERVAL_S * up;
        change[3][VELOCITY + 1] = INTERVAL_S * turn;
        change[4][1] = INTERVAL_S * (cos_ff * up - sin_f * force[1]);
        change[4][VELOCITY] = -INTERVAL_S * turn;
    }
#endif
    propagate(s, (const narx_real(*)[N])change, decay);
    noise = s->known ? 0 : CENTRE_NOISE;
    for (axis = 0; axis < 3; axis++) {
        s->covariance[axis][axis] += ANGLE_NOISE + RATE_NOISE * rates / square(cos_f);
        s->covariance[BIAS + axis][BIAS + axis] += BIAS_NOISE;
    }
    for (axis = 0; axis < 2; axis++)
        s->covariance[CENTRE + axis][CENTRE + axis] += noise;
    for (k = VELOCITY; k < N; k++)
        s->covariance[k][k] += VELOCITY_NOISE;
    if (s->scatter < REST_LEAST && means < MOST_BIAS_SQUARE)
        for (axis = 0; axis < 3; axis++)
            measure_state(s, BIAS + axis, REST_VARIANCE, s->mean_rate[axis] - s->x[BIAS + axis]);
    s->since_s += INTERVAL_S;
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
        const int swung = s->since_s > SHORTEST_SWING_S && s->since_s < LONGEST_SWING_S;
        if (swung) {
            learn_from_swing(s);
            if (!(fabs${f}(s->odd[0]) + fabs${f}(s->odd[1]) > 0))
                s->idle_s = 0;
        }
        s->period_s = swung ? s->since_s : 0;
        s->since_s = s->samples = s->sum_turn = 0;
        memset(s->sum_angles, 0, sizeof s->sum_angles);
        memcpy(s->before, s->x, sizeof s->before);
    }
    for (axis = 0; axis < 3; axis++) {
        const narx_real correction = s->x[axis] - carried[axis];
        for (k = NARX_PAST_ANGLES - 1; k > 0; k--)
            s->past[axis][k] = s->past[axis][k - 1] + correction;
        s->past[axis][0] = s->x[axis];
    }
}

void narx_start(narx_state *state, const narx_real *initial_angles)
{
    int i, k;
    memset(state, 0, sizeof *state);
    memcpy(state->x, X_START, sizeof state->x);
    state->known = initial_angles != NULL;
    for (i = 0; i < N; i++)
        state->covariance[i][i] = state->known ? KNOWN_VARIANCE[i] : UNKNOWN_VARIANCE[i];
    if (initial_angles)
        for (i = 0; i < 3; i++) {
            state->x[i] = initial_angles[i];
            for (k = 0; k < NARX_PAST_ANGLES; k++)
                state->past[i][k] = initial_angles[i];
        }
    state->scatter = 1;
    state->idle_s = IDLE_MOST_S;
}

void narx_step(narx_state *state, const narx_real inputs[NARX_INPUTS], narx_real angles[3])
{
    int i;
    for (i = 0; i < NARX_INPUTS; i++) {
        if (!isfinite(inputs[i])) {
            state->missing_s += INTERVAL_S;
            angles[0] = angles[1] = angles[2] = NAN;
            return;
        }
    }
    estimate(state, inputs);
    memcpy(angles, state->x, 3 * sizeof angles[0]);
}

void narx_standard_deviation(const narx_state *state, narx_real deviation[3])
{
    int axis;
    for (axis = 0; axis < 3; axis++)
        deviation[axis] = STD_SCALE[axis] * sqrt${f}(state->covariance[axis][axis]);
}

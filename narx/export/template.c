/* ${title}: see the header. ISO C99, needs only the standard math library. */
#include "${header}"

#include <math.h>
#include <string.h>

#define INTERVAL_S ${interval_s}
#define INTERVAL_UPPER_S ${interval_upper_s} /* its multiples are exact: ticks do not drift */
#define INTERVAL_LOWER_S ${interval_lower_s}
#define HALF_INTERVAL_S ${half_interval_s}
#define HALF 0.5${f}
#define LONGEST_PAUSE_S ${longest_pause_s} /* longer pauses count as this one */
#define LOST_MOST ${lost_most} /* at most so many missed ticks are counted */
#define ON_TICK ${on_tick} /* in intervals: a sample this close to a tick counts as on it */
#define SMALLEST_COS_FRONTAL ${smallest_cos_frontal}

/* Short series for sine, cosine and tanh of small arguments: faster than the library's. */
#define SHORT_SERIES ${short_series}

static void sine_cosine(narx_real x, narx_real *sine, narx_real *cosine)
{
#if SHORT_SERIES
    const narx_real u = x * x;
    if (u < ${short_sine_square}) {
        *sine = x * (${short_sine});
        *cosine = ${short_cosine};
        return;
    }
    if (u < ${sine_square}) {
        *sine = x * (${sine});
        *cosine = ${cosine};
        return;
    }
#endif
    *sine = sin${f}(x);
    *cosine = cos${f}(x);
}

static narx_real hyperbolic_tangent(narx_real x)
{
#if SHORT_SERIES
    const narx_real u = x * x;
    if (u < ${tanh_square})
        return x * (${tanh});
    if (u < 1) /* continued fraction, to 1e-7 */
        return x * (945 + u * (105 + u)) / (945 + u * (420 + u * 15));
#endif
    return tanh${f}(x);
}

/* Secant and tangent; the cosine is kept away from zero. */
static void secant_tangent(narx_real x, narx_real *secant, narx_real *tangent)
{
    narx_real sine, cosine;
#if SHORT_SERIES
    const narx_real u = x * x;
    if (u < ${secant_square}) {
        *secant = ${secant};
        *tangent = x * (${tangent});
        return;
    }
#endif
    sine_cosine(x, &sine, &cosine);
    if (fabs${f}(cosine) < SMALLEST_COS_FRONTAL)
        cosine = cosine < 0 ? -SMALLEST_COS_FRONTAL : SMALLEST_COS_FRONTAL;
    *secant = 1 / cosine;
    *tangent = sine * *secant;
}

/* Returns the secant of the frontal angle. */
static narx_real rates_of_angles(const narx_real axis_rates[3], const narx_real tilt[2],
                                 narx_real rates[3])
{
    narx_real sin_s, cos_s, secant, tangent, turning;
    sine_cosine(tilt[0], &sin_s, &cos_s);
    secant_tangent(tilt[1], &secant, &tangent);
    turning = axis_rates[2] * cos_s - axis_rates[1] * sin_s;
    rates[2] = turning * secant;
    rates[1] = axis_rates[1] * cos_s + axis_rates[2] * sin_s;
    rates[0] = axis_rates[0] - turning * tangent;
    return secant;
}

${network}
/* ---- the recurrence, one interval at a time ---- */

${recurrence}
/* ---- samples, missing samples and time ---- */

/* Adds to a time and keeps what rounding loses: two precisions would soon disagree on whether a
   sample with jitter is before a tick. */
static narx_real plus(narx_real sum, narx_real time_s, narx_real *lower)
{
    const narx_real total = sum + time_s, added = total - sum;
    *lower += (sum - (total - added)) + (time_s - added);
    return total;
}

static int usable(const narx_real inputs[NARX_INPUTS])
{
    int i;
    for (i = 0; i < NARX_INPUTS; i++) /* false for NaN, too */
        if (!(fabs${f}(inputs[i]) <= (i < 3 ? NARX_RATE_LIMIT_RAD_S : NARX_FORCE_LIMIT_M_S2)))
            return 0;
    return 1;
}

void narx_start(narx_state *state, const narx_real *initial_angles)
{
    int axis;
    memset(state, 0, sizeof *state);
    for (axis = 0; initial_angles && axis < 3; axis++)
        if (!(fabs${f}(initial_angles[axis]) <= NARX_START_LIMIT_RAD))
            initial_angles = NULL;
    if (initial_angles)
        memcpy(state->angles, initial_angles, sizeof state->angles);
    begin(state, initial_angles);
}

void narx_step_after(narx_state *state, narx_real interval_s, const narx_real inputs[NARX_INPUTS],
                     narx_real angles[3])
{
    narx_real rest = 0, lower = 0;
    int due = 1, paused, axis, i;
    if (interval_s > 0) {
        state->since_s = plus(state->since_s, interval_s, &state->lower_s);
        if (!(state->since_s < LONGEST_PAUSE_S)) {
            state->since_s = LONGEST_PAUSE_S;
            state->lower_s = 0;
        }
    }
    if (!(interval_s > 0) || !usable(inputs)) {
        angles[0] = angles[1] = angles[2] = NAN;
        state->on_tick = 0;
        state->arrived = NARX_MISSING;
        return;
    }
    paused = !state->seen || state->since_s > NARX_MAX_GAP_S * (1 + ON_TICK);
    if (!paused) {
        const narx_real elapsed = plus(state->past_s, state->since_s, &state->lower_s);
        narx_real whole;
        due = (int)(elapsed * NARX_SAMPLING_RATE_HZ + ON_TICK);
        whole = elapsed - (narx_real)due * INTERVAL_UPPER_S;
        lower = state->lower_s - (narx_real)due * INTERVAL_LOWER_S;
        rest = whole + lower;
        lower -= rest - whole;
        if (rest < ON_TICK * INTERVAL_S)
            rest = lower = 0;
    }
#if LOST_MOST > 0
    else {
        const int lost = (int)(state->since_s * NARX_SAMPLING_RATE_HZ + HALF) - 1;
        if (lost > 0)
            lose(state, lost < LOST_MOST ? lost : LOST_MOST);
    }
#endif
    for (; due > 0; due--) {
        narx_real tick[NARX_INPUTS];
        const narx_real before = rest + (narx_real)(due - 1) * INTERVAL_S;
        const narx_real back = paused || !(before > 0) ? 0 : before / state->since_s;
        for (i = 0; i < NARX_INPUTS; i++)
            tick[i] = inputs[i] - back * (inputs[i] - state->latest[i]);
        advance(state, tick);
    }
    memcpy(state->latest, inputs, sizeof state->latest);
    state->arrived = paused && state->seen ? NARX_AFTER_PAUSE : NARX_GOOD;
    state->seen = 1;
    state->since_s = 0;
    state->past_s = rest;
    state->lower_s = lower;
    state->on_tick = !(rest > 0);
    memcpy(angles, state->angles, sizeof state->angles);
    if (rest > 0) {
        narx_real rates[3];
        rates_of_angles(inputs, state->angles, rates);
        for (axis = 0; axis < 3; axis++)
            angles[axis] += rest * rates[axis];
    }
}

void narx_step(narx_state *state, const narx_real inputs[NARX_INPUTS], narx_real angles[3])
{
    if (!(state->on_tick && usable(inputs))) {
        narx_step_after(state, INTERVAL_S, inputs, angles);
        return;
    }
    advance(state, inputs);
    state->arrived = NARX_GOOD;
    memcpy(state->latest, inputs, sizeof state->latest);
    memcpy(angles, state->angles, sizeof state->angles);
}

int narx_quality(const narx_state *state)
{
    if (state->arrived != NARX_GOOD)
        return state->arrived;
    if (!state->by_network)
        return NARX_STARTING;
    return is_doubtful(state) ? NARX_DOUBTFUL : NARX_GOOD;
}

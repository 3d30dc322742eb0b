/* Covariance of every state with the sum of a relative angle and lean times the lean's state;
 * returns the variance of that sum. */
static narx_real spread_of(const narx_state *s, int axis, narx_real lean, narx_real spread[N])
{
    int j;
    for (j = 0; j < N; j++)
        spread[j] = s->covariance[axis][j] + lean * s->covariance[LEAN][j];
    return spread[axis] + lean * spread[LEAN];
}

/* The covariance is that of angles relative to the posture, posture, bias, lean and velocity. The
 * variance of the absolute heading is unbounded; the small variance of the relative heading would
 * lose its digits in it. */

/* Scalar Kalman update; spread: covariance times direction, total: variance of the residual. */
static void update(narx_state *s, const narx_real spread[N], narx_real total, narx_real residual)
{
    const narx_real inverse = 1 / total, step = inverse * residual;
    int i, j;
    for (i = 0; i < N; i++) {
        const narx_real gain = spread[i] * inverse;
        s->x[i] += (i < CENTRE ? spread[i] + spread[CENTRE + i] : spread[i]) * step;
        for (j = 0; j <= i; j++) {
            s->covariance[i][j] -= gain * spread[j];
            s->covariance[j][i] = s->covariance[i][j];
        }
    }
}

/* Increases the variance of a posture, not that of the absolute angle. */
static void widen_posture(narx_state *s, int axis, narx_real variance)
{
    s->covariance[axis][axis] += variance;
    s->covariance[CENTRE + axis][CENTRE + axis] += variance;
    s->covariance[axis][CENTRE + axis] -= variance;
    s->covariance[CENTRE + axis][axis] -= variance;
}

static void measure_state(narx_state *s, int at, narx_real variance, narx_real residual)
{
    narx_real spread[N];
    memcpy(spread, s->covariance[at], sizeof spread);
    update(s, spread, spread[at] + variance, residual);
}

/* Transition over one sample, x <- (1 + change) x: columns and factors of the nonzero entries. */
#define MOVING (AIDED ? 5 : 3)
#define MOST 5
typedef struct {
    int n[MOVING];
    int column[MOVING][MOST];
    narx_real factor[MOVING][MOST];
} change_type;

static void put(change_type *change, int row, int column, narx_real factor)
{
    if (factor < 0 || factor > 0) {
        change->column[row][change->n[row]] = column;
        change->factor[row][change->n[row]++] = factor;
    }
}

/* Propagates the covariance over one sample; one half is computed, since it is symmetric. */
static void propagate(narx_state *s, const change_type *change, narx_real loss)
{
    static const int ROW[5] = {0, 1, 2, VELOCITY, VELOCITY + 1};
    narx_real moved[MOVING][N];
    int i, j, k;
    if (loss > 0)
        for (i = 0; i < 2; i++) {
            for (j = 0; j < N; j++) {
                const narx_real lost = loss * s->covariance[CENTRE + i][j];
                s->covariance[i][j] += lost;
                s->covariance[CENTRE + i][j] -= lost;
            }
            for (j = 0; j < N; j++) {
                const narx_real lost = loss * s->covariance[j][CENTRE + i];
                s->covariance[j][i] += lost;
                s->covariance[j][CENTRE + i] -= lost;
            }
        }
    memset(moved, 0, sizeof moved);
    for (i = 0; i < MOVING; i++)
        for (k = 0; k < change->n[i]; k++) {
            const narx_real *const covariance = s->covariance[change->column[i][k]];
            const narx_real factor = change->factor[i][k];
            for (j = 0; j < N; j++)
                moved[i][j] += factor * covariance[j];
        }
    for (i = 0; i < MOVING; i++) {
        narx_real *const row = s->covariance[ROW[i]];
        for (j = CENTRE; j < VELOCITY; j++) {
            row[j] += moved[i][j];
            s->covariance[j][ROW[i]] = row[j];
        }
        for (j = 0; j <= i; j++) {
            narx_real total = moved[i][ROW[j]] + moved[j][ROW[i]];
            for (k = 0; k < change->n[j]; k++)
                total += moved[i][change->column[j][k]] * change->factor[j][k];
            row[ROW[j]] += total;
            s->covariance[ROW[j]][ROW[i]] = row[ROW[j]];
        }
    }
}

/* Factor on the standard deviation for motion that does not resemble the swing of a leg, which is
 * faster forward than backward. */
static narx_real std_growth(const narx_state *state)
{
    const narx_real skewness = state->cube / (state->square * sqrt${f}(state->square));
    const narx_real lacking = skewness < LEG_SKEWNESS ? 1 - skewness / LEG_SKEWNESS : 0;
    const narx_real growth = 1 + STD_GROWTH * lacking;
    return growth < MOST_GROWTH ? growth : MOST_GROWTH;
}

/* What the recent corrections add to the standard deviation of a tilt angle. */
static narx_real corrected(const narx_state *state, int axis)
{
    return axis < 2 ? squared(state->corrected[axis]) * PER_CORRECTED : 0;
}

void narx_standard_deviation(const narx_state *state, narx_real deviation[3])
{
    const narx_real growth = std_growth(state);
    int axis;
    for (axis = 0; axis < 3; axis++) {
        const narx_real *const relative = state->covariance[axis];
        const narx_real *const posture = state->covariance[CENTRE + axis];
        const narx_real variance =
            relative[axis] + 2 * relative[CENTRE + axis] + posture[CENTRE + axis] +
            squared(DELAY_S * state->rates[axis][0]);
        const narx_real scale = growth * STD_SCALE[axis];
        deviation[axis] = sqrt${f}((variance > 0 ? squared(scale) * variance : 0) +
                                   squared(corrected(state, axis)));
        if (state->known && deviation[axis] < ALIGNMENT)
            deviation[axis] = ALIGNMENT;
    }
}

static int is_doubtful(const narx_state *state)
{
    return std_growth(state) > DOUBTFUL_GROWTH || corrected(state, 0) > MOST_CORRECTED_RAD ||
           corrected(state, 1) > MOST_CORRECTED_RAD;
}

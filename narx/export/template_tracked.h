/* ${title}
 *
 * Three orientation angles of a body segment from its gyroscope, sample by sample, and their
 * standard deviations.
 *
 *     narx_state state;
 *     narx_start(&state, NULL);
 *     for (;;) { ... narx_step(&state, inputs, angles); }
 *
 * Axes, in this order: sagittal, frontal, transverse. With x forward, y left and z up along the
 * segment, the first three inputs are (-y, -x, z) of the gyroscope on a right leg and (-y, x, -z)
 * on a left leg, in rad/s. Where NARX_INPUTS is 6, the specific force x, y, z in m/s^2 follows, y
 * with the other sign on a left leg. Angles are in rad: flexion, abduction and internal rotation
 * are positive.
 */
#ifndef ${guard}
#define ${guard}

#ifdef __cplusplus
extern "C" {
#endif

typedef ${real} narx_real;

#define NARX_SAMPLING_RATE_HZ ${sampling_rate_hz} /* samples must come at this rate */
#define NARX_IDENTITY ${identity}
#define NARX_INPUTS ${inputs}
#define NARX_STATES ${states}
#define NARX_PAST_RATES ${past_rates}
#define NARX_PAST_ANGLES ${past_angles}

typedef struct {
    narx_real x[NARX_STATES]; /* angles, posture, bias (3 each), lean, velocity (aided: 2) */
    narx_real covariance[NARX_STATES][NARX_STATES];
    narx_real turn;                               /* turn rate, averaged over half a second */
    narx_real swing, high, low, span;             /* of the leg, and its turning points */
    narx_real since_s, idle_s, period_s;          /* since a turning point, a swing; of the last */
    narx_real trust, scatter, missing_s, samples;
    narx_real sum_angles[3], sum_turn, before[2]; /* over the swing under way, at its start */
    narx_real odd[3], mean_rate[3];
    narx_real rates[3][NARX_PAST_RATES];          /* of the angles, newest first */
    narx_real past[3][NARX_PAST_ANGLES];          /* angles, newest first */
    int rising, known;
    int by_network;                               /* whether the network carried the angles */
} narx_state;

/* initial_angles: start pose, zero when standing upright; NULL if it is unknown. */
void narx_start(narx_state *state, const narx_real *initial_angles);

/* Angles are NaN if an input is NaN or infinite: a missing sample, of which only the time counts. */
void narx_step(narx_state *state, const narx_real inputs[NARX_INPUTS], narx_real angles[3]);

/* Standard deviations of the latest angles, rad. */
void narx_standard_deviation(const narx_state *state, narx_real deviation[3]);

#ifdef __cplusplus
}
#endif

#endif

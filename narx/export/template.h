/* ${title}
 *
 * Three orientation angles of a body segment from its gyroscope, sample by sample.
 *
 *     narx_state state;
 *     narx_start(&state, NULL);
 *     for (;;) { ... narx_step(&state, axis_rates, angles); }
 *
 * Axes, in this order: sagittal, frontal, transverse. With x forward, y left and z up along the
 * segment, axis_rates is (-y, -x, z) of the gyroscope on a right leg and (-y, x, -z) on a left
 * leg, in rad/s, static bias removed. Angles are in rad: flexion, abduction and internal rotation
 * are positive.
 */
#ifndef ${guard}
#define ${guard}

#ifdef __cplusplus
extern "C" {
#endif

typedef ${real} narx_real;

#define NARX_SAMPLING_RATE_HZ ${sampling_rate_hz} /* samples must come at this rate */
#define NARX_MOVING_SAMPLES ${moving_samples}UL /* in movement, before the network takes over */
#define NARX_NETWORK_STATE ${n_state}

typedef struct {
    narx_real angles[3];      /* rad */
    narx_real rates[3];       /* latest rates of the angles, rad/s */
    narx_real posture_sum[3]; /* weighted sum over the end of the start-up, rad */
    narx_real posture_weight; /* sum of those weights */
    narx_real mean_square;    /* of the rates over the latest second, rad^2/s^2 */
    narx_real posture[3];     /* angle about which the network swings, rad */
    narx_real mean[3];        /* of the latest deviations from it, taken off, rad */
    narx_real network[3][NARX_NETWORK_STATE]; /* past inputs, then past outputs, newest first */
    unsigned long samples;                    /* since the start, while starting */
    unsigned long moving_left;                /* samples in movement, left of the start-up */
    int known;                                /* whether the start pose was given */
} narx_state;

/* initial_angles: start pose, zero when standing upright; NULL if it is unknown. */
void narx_start(narx_state *state, const narx_real *initial_angles);

/* Angles are NaN, and the state stays as it was, if a rate is NaN or infinite: a missing sample. */
void narx_step(narx_state *state, const narx_real axis_rates[3], narx_real angles[3]);

#ifdef __cplusplus
}
#endif

#endif

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
 *
 * Written by narx-orientation ${version} from the checkpoint of SHA-256
 * ${sha256};
 * the whole of what it is, as JSON: NARX_IDENTITY.
 */
#ifndef ${guard}
#define ${guard}

#ifdef __cplusplus
extern "C" {
#endif

typedef ${real} narx_real;

#define NARX_SAMPLING_RATE_HZ ${sampling_rate_hz}
#define NARX_RATE_LIMIT_RAD_S ${rate_limit_rad_s} /* a rate beyond is a fault: the sample counts as missing */
#define NARX_MAX_GAP_S ${max_gap_s} /* between samples, up to which what was lost is interpolated */
#define NARX_MOVING_SAMPLES ${moving_samples}UL /* in movement, before the network takes over */
#define NARX_NETWORK_STATE ${n_state}
#define NARX_IDENTITY ${identity}

typedef struct {
    narx_real angles[3];      /* rad */
    narx_real rates[3];       /* latest rates of the angles, rad/s */
    narx_real posture_sum[3]; /* weighted sum in the start-up, rad */
    narx_real posture_weight; /* sum of those weights */
    narx_real mean_square;    /* of the rates over the latest second, rad^2/s^2 */
    narx_real posture[3];     /* angle about which the network swings, rad */
    narx_real mean[3];        /* of the latest deviations from it, taken off, rad */
    narx_real network[3][NARX_NETWORK_STATE]; /* past rates, then past deviations, newest first */
    narx_real latest[3];                      /* latest sample, rad/s */
    narx_real since_s;                        /* time since it */
    narx_real past_s;                         /* time by which it came after its tick */
    unsigned long samples;                    /* since the start, while starting */
    unsigned long moving_left;                /* samples in movement, left of the start-up */
    unsigned char known;                      /* whether the start pose was given */
    unsigned char seen;                       /* whether there was a sample yet */
} narx_state;

/* initial_angles: start pose, zero when standing upright; NULL if it is unknown. */
void narx_start(narx_state *state, const narx_real *initial_angles);

/* One sample, NARX_SAMPLING_RATE_HZ of them a second, lost ones as NaN. The angles of a missing
 * sample are NaN; what was lost is made up with the next one, unless the gap is too long: then the
 * angles go on from where they were. */
void narx_step(narx_state *state, const narx_real axis_rates[3], narx_real angles[3]);

/* The same at any time: interval_s since the call before. Packets that were lost altogether, jitter
 * and another sampling rate then cost little. */
void narx_step_after(narx_state *state, narx_real interval_s, const narx_real axis_rates[3],
                     narx_real angles[3]);

#ifdef __cplusplus
}
#endif

#endif

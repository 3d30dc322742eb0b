/* ${title}
 *
 * Three orientation angles of a body segment from its gyroscope, sample by sample.
 *
 *     narx_state state;
 *     narx_start(&state, NULL);
 *     for (;;) { ... narx_step(&state, inputs, angles); }
 *
 * Axes, in this order: sagittal, frontal, transverse. With x forward, y left and z up along the
 * segment, the first three inputs are (-y, -x, z) of the gyroscope on a right leg and (-y, x, -z)
 * on a left leg, in rad/s, static bias removed. Where NARX_INPUTS is 6, the specific force x, y, z
 * in m/s^2 follows, y with the other sign on a left leg. Angles are in rad: flexion, abduction and
 * internal rotation are positive.
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
#define NARX_INPUTS ${inputs}
/* an input beyond is a fault: the sample counts as missing */
#define NARX_RATE_LIMIT_RAD_S ${rate_limit_rad_s}
#define NARX_FORCE_LIMIT_M_S2 ${force_limit_m_s2}
#define NARX_MAX_GAP_S ${max_gap_s} /* between samples, up to which what was lost is interpolated */
#define NARX_TRACKED ${tracked}
#define NARX_IDENTITY ${identity}

typedef struct {
    narx_real angles[3];           /* rad */
    narx_real latest[NARX_INPUTS]; /* latest sample */
    narx_real since_s;             /* time since it */
    narx_real past_s;              /* time by which it came after its tick */
    unsigned char known;           /* whether the start pose was given */
    unsigned char seen;            /* whether there was a sample yet */
${fields}} narx_state;

/* initial_angles: start pose, zero when standing upright; NULL if it is unknown. */
void narx_start(narx_state *state, const narx_real *initial_angles);

/* One sample, NARX_SAMPLING_RATE_HZ of them a second, lost ones as NaN. The angles of a missing
 * sample are NaN; what was lost is made up with the next one, unless the gap is too long: then the
 * angles go on from where they were. */
void narx_step(narx_state *state, const narx_real inputs[NARX_INPUTS], narx_real angles[3]);

/* The same at any time: interval_s since the call before. Packets that were lost altogether, jitter
 * and another sampling rate then cost little. */
void narx_step_after(narx_state *state, narx_real interval_s, const narx_real inputs[NARX_INPUTS],
                     narx_real angles[3]);

#if NARX_TRACKED
/* Standard deviations of the latest angles, rad. */
void narx_standard_deviation(const narx_state *state, narx_real deviation[3]);
#endif

#ifdef __cplusplus
}
#endif

#endif

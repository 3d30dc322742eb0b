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
 * NARX_IDENTITY is its complete description, as JSON.
 */
#ifndef ${guard}
#define ${guard}

#ifdef __cplusplus
extern "C" {
#endif

typedef ${real} narx_real;

#define NARX_SAMPLING_RATE_HZ ${sampling_rate_hz}
#define NARX_INPUTS ${inputs}
#ifndef NARX_AXES /* define it as 1 for the sagittal axis alone, if the axes are not coupled */
#define NARX_AXES 3
#endif
/* an input beyond these limits is a fault: the sample counts as missing */
#define NARX_RATE_LIMIT_RAD_S ${rate_limit_rad_s}
#define NARX_FORCE_LIMIT_M_S2 ${force_limit_m_s2}
#define NARX_START_LIMIT_RAD ${start_limit_rad}
#define NARX_MAX_GAP_S ${max_gap_s} /* longest gap between samples that is interpolated */
#define NARX_TRACKED ${tracked}
#define NARX_IDENTITY ${identity}

typedef struct {
    narx_real angles[3];           /* rad */
    narx_real latest[NARX_INPUTS]; /* latest sample */
    narx_real since_s;             /* time since the latest sample */
    narx_real past_s;              /* delay of that sample after its tick */
    narx_real lower_s;             /* digits that the two times lose */
    unsigned char known;           /* whether the start pose was given */
    unsigned char seen;            /* whether there has been a sample */
    unsigned char on_tick;         /* whether the latest one was on its tick */
    unsigned char arrived;         /* its quality, apart from that of the method */
    unsigned char by_network;      /* whether the network gave the angles */
${fields}} narx_state;

/* initial_angles: start pose, zero when standing upright; NULL if it is unknown, which it also is if
 * an angle is not finite or beyond NARX_START_LIMIT_RAD. */
void narx_start(narx_state *state, const narx_real *initial_angles);

/* One sample, at NARX_SAMPLING_RATE_HZ samples per second; pass a lost sample as NaN. The angles of
 * a missing sample are NaN; the gap is interpolated at the next sample, unless it is longer than
 * NARX_MAX_GAP_S: then the angles continue from their values before the gap. */
void narx_step(narx_state *state, const narx_real inputs[NARX_INPUTS], narx_real angles[3]);

/* The same for any sampling times: interval_s is the time since the previous call. Lost packets,
 * jitter and a different sampling rate then cause little error. */
void narx_step_after(narx_state *state, narx_real interval_s, const narx_real inputs[NARX_INPUTS],
                     narx_real angles[3]);

/* Quality of the latest angles: regular; the first sample after a gap that was not interpolated; no
 * usable sample; start-up or no walking, so that the rates are integrated; with a tracker, motion
 * that does not resemble the swing of a leg. */
enum { NARX_GOOD, NARX_AFTER_PAUSE, NARX_MISSING, NARX_STARTING, NARX_DOUBTFUL };
int narx_quality(const narx_state *state);

#if NARX_TRACKED
/* Standard deviations of the latest angles, rad; larger where the motion is doubtful. */
void narx_standard_deviation(const narx_state *state, narx_real deviation[3]);
#endif

#ifdef __cplusplus
}
#endif

#endif

#define NARX_STATES ${states}
#define NARX_PAST_RATES ${past_rates}
#define NARX_PAST_ANGLES ${past_angles}
    narx_real x[NARX_STATES]; /* angles, posture, bias (3 each), lean, velocity (aided: 2) */
    narx_real covariance[NARX_STATES][NARX_STATES];
    narx_real heading;                            /* total of the steps subtracted from x[2] */
    narx_real lower[4];                           /* rounding errors: posture, its variance */
    narx_real turn, turning;                      /* turn rate, averaged over a step, a stride */
    narx_real swing, high, low, span;             /* angle of the leg, turning points, range */
    narx_real swing_s, idle_s, period_s;          /* this swing, time since one, last swing */
    narx_real trust, scatter, missing_s, samples;
    narx_real sum_angles[3], sum_turn, before[2]; /* over the present swing, at its start */
    narx_real odd[3], mean_rate[3];
    narx_real square, cube;                       /* means of the sagittal rate's in walking */
    narx_real corrected[2];                       /* recent corrections of the tilt angles */
    narx_real rates[3][NARX_PAST_RATES];          /* of the angles, newest first */
    narx_real past[3][NARX_PAST_ANGLES];          /* angles, newest first */
    unsigned char rising;

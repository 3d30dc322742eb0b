#define NARX_MOVING_SAMPLES ${moving_samples}UL /* in movement, before the network takes over */
#define NARX_NETWORK_STATE ${n_state}
    narx_real rates[3];        /* latest rates of the angles, rad/s */
    narx_real posture_sum[3];  /* weighted sum in the start-up, rad */
    narx_real posture_weight;  /* sum of those weights */
    narx_real mean_square;     /* of the rates over the latest second, rad^2/s^2 */
    narx_real posture[3];      /* angle to which the network's output is relative, rad */
    narx_real returning[3];    /* what the slow mean that is subtracted gives back of it, rad */
    narx_real next[3];         /* angles expected at the next sample, rad */
    narx_real network[3][NARX_NETWORK_STATE]; /* past rates, then past deviations, newest first */
    unsigned long samples;     /* since the start, during the start-up */
    unsigned long moving_left; /* samples in movement until the start-up ends */

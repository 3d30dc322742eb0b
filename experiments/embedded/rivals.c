/* The rivals for bench.c: the sagittal axis alone, as the papers have it. Constants are folded.
 *
 * METHOD 1: complementary filter, 2: gyro integration-based orientation filter in real time on
 * sensors that filter themselves, 3: pseudo-integrator, 4: 2-point method between its two points,
 * whose line of drift is a constant here: it is found once they are known. */
#include <math.h>

#include "constants.h"

void bench_start(void);
void bench_step(const float inputs[6], float angles[3]);

static float angle, before, slow;
static unsigned char started;

void bench_start(void)
{
}

void bench_step(const float inputs[6], float angles[3])
{
    const float rate = inputs[0];
#if METHOD == 1
    if (started) {
        const float predicted = angle + INTERVAL_S * rate;
        float difference = atan2f(inputs[3], inputs[5]) - predicted;
        if (difference > PI)
            difference -= 2 * PI;
        else if (difference < -PI)
            difference += 2 * PI;
        angle = predicted + GAIN * difference;
    }
#elif METHOD == 2
    if (started) {
        const float norm_square =
            inputs[3] * inputs[3] + inputs[4] * inputs[4] + inputs[5] * inputs[5];
        if (fabsf(rate) < THRESHOLD_RAD_S && norm_square > LOW && norm_square < HIGH)
            angle = atan2f(inputs[3], inputs[5]);
        else
            angle += HALF_INTERVAL_S * (rate + before);
    }
    before = rate;
#elif METHOD == 4
    angle = started ? angle + HALF_INTERVAL_S * (rate + before) : atan2f(inputs[3], inputs[5]);
    before = rate;
    slow = slow + SLOPE;
#else
    {
        const float integral = angle + slow, following = KEPT * integral + TURN * (rate + before);
        slow = KEPT * slow + LEAK * (following + integral);
        angle = following - slow;
        before = rate;
    }
#endif
    started = 1;
    angles[0] = METHOD == 4 ? angle - (LINE + slow - SLOPE) : angle;
}

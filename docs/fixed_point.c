/* A step of three coupled axes with 16-bit factors and 32-bit sums, for docs/fixed_point.py. Angles
 * are in 2^-28 rad, their upper halves in 2^-12 rad, rates in 2^-10 rad/s, sines in 2^-14. */
#include <stdint.h>

#include "constants.h"

void bench_start(void);
void bench_step(const float inputs[3], float angles[3]);

static int32_t deviation[3], angle[3];
static int16_t past[3][2], rate_before[3], next[2];

static int32_t product(int16_t a, int16_t b)
{
    return (int32_t)a * b;
}

static int16_t in_12(int16_t a, int16_t b)
{
    return (int16_t)(product(a, b) >> 12);
}

static int16_t in_14(int32_t sum)
{
    return (int16_t)((sum + 8192) >> 14);
}

static int16_t upper(int32_t value)
{
    return (int16_t)((value + 32768) >> 16);
}

void bench_start(void)
{
}

void bench_step(const float inputs[3], float angles[3])
{
    const int16_t x = next[0], y = next[1], u = in_12(x, x), v = in_12(y, y);
    const int16_t sine = in_12(x, 16384 + in_12(u, -2731 + in_12(u, 136)));
    const int16_t cosine = 16384 + in_12(u, -8192 + in_12(u, 683 - in_12(u, 22)));
    const int16_t secant = 16384 + in_12(v, 8192 + in_12(v, 3413));
    const int16_t tangent = in_12(y, 16384 + in_12(v, 5461 + in_12(v, 2185)));
    int16_t rates[3], now[3], turning;
    uint8_t axis;
    for (axis = 0; axis < 3; axis++)
        rates[axis] = (int16_t)(inputs[axis] * 1024 + (inputs[axis] < 0 ? -0.5f : 0.5f));
    turning = in_14(product(rates[2], cosine) - product(rates[1], sine));
    now[2] = in_14(product(turning, secant));
    now[1] = in_14(product(rates[1], cosine) + product(rates[2], sine));
    now[0] = rates[0] - in_14(product(turning, tangent));
    for (axis = 0; axis < 3; axis++) {
        const int16_t latest = past[axis][0];
        int32_t change = (product(now[axis], RATE) + product(rate_before[axis], RATE_BEFORE)) >> 3;
        const int16_t sum = latest + upper(change);
        change += (product(latest, LATEST) + product(past[axis][1], BEFORE)) >> 8;
        change += product(in_12(in_12(sum, sum), sum), CUBE) >> 8;
        deviation[axis] += change;
        past[axis][1] = latest;
        past[axis][0] = upper(deviation[axis]);
        rate_before[axis] = now[axis];
        angle[axis] += change;
        angle[axis] -= angle[axis] >> 15; /* washout of about 300 s */
        if (axis < 2)
            next[axis] = past[axis][0] + upper(change);
        angles[axis] = (float)angle[axis] * 3.7252903e-9f;
    }
}

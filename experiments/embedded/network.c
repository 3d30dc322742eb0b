/* The exported network for bench.c. */
#include <stddef.h>

#include "narx.h"

void bench_start(void);
void bench_step(const float inputs[NARX_INPUTS], float angles[3]);

static narx_state state;

void bench_start(void)
{
    narx_start(&state, NULL);
}

void bench_step(const float inputs[NARX_INPUTS], float angles[3])
{
    narx_step(&state, inputs, angles);
}

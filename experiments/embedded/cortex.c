/* Counts the instructions of a method on a Cortex-M in qemu, sample by sample.
 *
 * With -icount shift=0 an instruction takes a nanosecond; SysTick counts these in steps of its clock.
 * A line is the count of steps in hexadecimal digits and the first angle as those of a float. */
#include <stdint.h>
#include <string.h>

#define PROGMEM
#include "signal.h" /* SAMPLES, COLUMNS, SIGNAL */

void bench_start(void);
void bench_step(const float inputs[COLUMNS], float angles[3]);

static int semihosting(int operation, const void *argument)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void put(char *text, uint32_t number)
{
    int k;
    for (k = 7; k >= 0; k--, number >>= 4)
        text[k] = "0123456789abcdef"[number & 15];
}

#define REGISTER(address) (*(volatile uint32_t *)(address))

static void run(void)
{
    char line[] = "00000000 00000000\n";
    int k;
#if defined(__ARM_FP)
    REGISTER(0xe000ed88) |= 0xfu << 20;
    __asm__ volatile("dsb\n\tisb");
#endif
    REGISTER(0xe000e014) = 0xffffff;
    REGISTER(0xe000e018) = 0;
    REGISTER(0xe000e010) = 5;
    bench_start();
    for (k = 0; k < SAMPLES; k++) {
        float inputs[COLUMNS], angles[3];
        uint32_t before, bits;
        memcpy(inputs, SIGNAL[k], sizeof inputs);
        before = REGISTER(0xe000e018);
        bench_step(inputs, angles);
        before = (before - REGISTER(0xe000e018)) & 0xffffff;
        memcpy(&bits, angles, sizeof bits);
        put(line, before);
        put(line + 9, bits);
        semihosting(4, line);
    }
    semihosting(0x18, (void *)0x20026);
    for (;;)
        ;
}

extern char stack_end[];
__attribute__((section(".vectors"), used)) static const void *const VECTORS[] = {stack_end, run};

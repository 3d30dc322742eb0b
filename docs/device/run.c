/* narx.c and narx.h in a program. Reads rows "interval_s,sagittal,frontal,transverse" (s, rad/s;
 * nan where lost) and writes the three angles (rad), their standard deviations (rad) and the
 * quality. Any other row is an error. */
#include <stdio.h>

#include "narx.h"

int main(void)
{
    narx_state state;
    char line[256];
    long number = 0;
    narx_start(&state, NULL); /* an unknown start pose */
    while (fgets(line, sizeof line, stdin)) {
        double row[4];
        int end = 0;
        number++;
        if (sscanf(line, "%lf,%lf,%lf,%lf %n", row, row + 1, row + 2, row + 3, &end) != 4
            || line[end]) {
            fprintf(stderr, "line %ld: expected four numbers, separated by commas\n", number);
            return 1;
        }
        const narx_real rates[3] = {(narx_real)row[1], (narx_real)row[2], (narx_real)row[3]};
        narx_real angles[3], std_rad[3];
        narx_step_after(&state, (narx_real)row[0], rates, angles);
        narx_standard_deviation(&state, std_rad);
        printf("%.17g,%.17g,%.17g,", (double)angles[0], (double)angles[1], (double)angles[2]);
        printf("%.17g,%.17g,%.17g,", (double)std_rad[0], (double)std_rad[1], (double)std_rad[2]);
        printf("%d\n", narx_quality(&state));
    }
    return 0;
}

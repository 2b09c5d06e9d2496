/* A double integrator under the controller of a problem file: prints, for every step, what it costs on top of the time that the
 * controller states for itself (us), and the resident memory (pages) after a tenth of the steps and after all.
 *
 *     loop PROBLEM STEPS
 */
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "bracketry.h"

static double seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void resident(void) {
    long whole, pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (file && fscanf(file, "%ld %ld", &whole, &pages) == 2) {
        printf("memory %ld\n", pages);
    }
    if (file) fclose(file);
}

int main(int count, char **arguments) {
    if (count != 3) return 2;
    BracketryCode code;
    BracketryController *controller = bracketry_controller_new(arguments[1], &code);
    const long steps = atol(arguments[2]);
    const double period = bracketry_controller_period(controller);
    double x[2] = {1.0, 0.0}, a;
    for (long k = 0; k < steps && code == BRACKETRY_CODE_OK; k++) {
        BracketryStatus status;
        const double start = seconds();
        code = bracketry_controller_step(controller, (double)k * period, x, 2, &a, 1, &status);
        printf("%.3f\n", 1e6 * (seconds() - start - status.prepare_seconds - status.feedback_seconds));
        x[0] += period * x[1] + period * period / 2 * a;
        x[1] += period * a;
        if (k + 1 == steps / 10 || k + 1 == steps) resident();
    }
    if (code != BRACKETRY_CODE_OK) {
        fprintf(stderr, "%s\n", bracketry_last_error());
        return 2;
    }
    bracketry_controller_free(controller);
    return 0;
}

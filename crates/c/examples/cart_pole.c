/* A cart with a pole, simulated here, in closed loop with the controller of a problem file: the pole is swung up and held although
 * measurements are noisy, one of them is lost, and the input acts one sample late.
 *
 *     cc cart_pole.c -I ../include -L LIBRARY -lbracketry_c -lm -o cart_pole && ./cart_pole cart_pole.toml
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "bracketry.h"

enum { STATES = 4, SAMPLES = 400, SUBSTEPS = 10 };

/* The plant: a pole of 0.08 kg in place of the 0.1 kg of the controller's model, and friction in the joint. */
static void rates(const double x[STATES], double u, double dx[STATES]) {
    const double M = 1.0, m = 0.08, l = 0.8, g = 9.81, c = 0.01;
    const double s = sin(x[1]), k = cos(x[1]), w = x[3], d = M + m - m * k * k;
    dx[0] = x[2];
    dx[1] = w;
    dx[2] = (-m * l * s * w * w + m * g * k * s + u) / d;
    dx[3] = (-m * l * k * s * w * w + u * k + (M + m) * g * s) / (l * d) - c * w;
}

/* One period of the plant by Runge-Kutta steps. */
static void simulate(double x[STATES], double u, double period) {
    const double h = period / SUBSTEPS;
    for (int n = 0; n < SUBSTEPS; n++) {
        double k[4][STATES], y[STATES];
        for (int stage = 0; stage < 4; stage++) {
            const double a = stage == 0 ? 0.0 : stage == 3 ? h : h / 2;
            for (int i = 0; i < STATES; i++) {
                y[i] = x[i] + (stage == 0 ? 0.0 : a * k[stage - 1][i]);
            }
            rates(y, u, k[stage]);
        }
        for (int i = 0; i < STATES; i++) {
            x[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
        }
    }
}

/* Noise of mean 0 and standard deviation 1, the same on every machine. */
static double noise(void) {
    static unsigned long long state = 1;
    double sum = -6.0;
    for (int i = 0; i < 12; i++) {
        state = state * 6364136223846793005ULL + 1442695040888963407ULL;
        sum += (double)(state >> 11) / 9007199254740992.0;
    }
    return sum;
}

static void check(BracketryCode code) {
    if (code != BRACKETRY_CODE_OK) {
        fprintf(stderr, "%s\n", bracketry_last_error());
        exit(2);
    }
}

int main(int count, char **arguments) {
    BracketryCode code;
    BracketryController *controller = bracketry_controller_new(count > 1 ? arguments[1] : "cart_pole.toml", &code);
    check(code);
    const double period = bracketry_controller_period(controller);
    const double deviation[STATES] = {1e-3, 1e-3, 5e-3, 5e-3};
    double x[STATES] = {0.0, 3.141592653589793, 0.0, 0.0}, acting = 0.0, worst = 0.0;
    int fallbacks = 0;
    for (int k = 0; k < SAMPLES; k++) {
        double y[STATES], decided;
        BracketryStatus status;
        for (int i = 0; i < STATES; i++) {
            y[i] = k == 250 ? NAN : x[i] + deviation[i] * noise();
        }
        if (k == SAMPLES / 2) {
            check(bracketry_controller_set_reference(controller, "goal", 0.5));
        }
        check(bracketry_controller_step(controller, k * period, y, STATES, &decided, 1, &status));
        if (status.outcome == BRACKETRY_OUTCOME_FALLBACK) {
            printf("sample %d: %s, input of the %s\n", k, bracketry_reason_name(status.reason), bracketry_source_name(status.source));
            fallbacks++;
        }
        /* What was decided one sample ago. */
        simulate(x, acting, period);
        acting = decided;
        if (k >= SAMPLES - 50) {
            worst = fmax(worst, fabs(x[1]));
        }
    }
    printf("cart at %.2f m; in the last second, the pole is at most %.2f degrees from upright\n", x[0], worst * 57.29577951308232);
    bracketry_controller_free(controller);
    return fallbacks == 1 && worst < 0.1 && fabs(x[0] - 0.5) < 0.05 ? 0 : 1;
}

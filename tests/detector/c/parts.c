/* What the detector is made of, looked at from within. Prints lines of a name and numbers. */
#include "skincad_detector.c"

#include <stdio.h>
#include <stdlib.h>

static skincad_detector detector, before;
static float volts[SKINCAD_CHANNELS * 3];
static skincad_alarm alarms[SKINCAD_MOST_ALARMS * 3];

static void functions(void)
{
    double worst_tanh = 0.0, worst_log = 0.0;
    long i;
    for (i = -3000000; i <= 3000000; i++) {
        const float x = (float)i * 5e-6f;
        worst_tanh = fmax(worst_tanh, fabs((double)squashed(x) - tanh((double)x)));
    }
    for (i = 0; i <= 3000000; i++) {
        const float x = expf((float)i * 2.5e-5f);
        const double right = log((double)x);
        worst_log = fmax(worst_log, fabs((double)logarithm(x) - right) / fmax(1.0, right));
    }
    printf("tanh %.3g %g %g\nlog %.3g\n", worst_tanh, (double)squashed(1e30f), (double)squashed(-1e30f), worst_log);
}

static void refusals(void)
{
    const float wrong[4] = {NAN, INFINITY, -INFINITY, 2e9f * SKINCAD_NOISE_V};
    int i, c;
    skincad_detector_init(&detector);
    printf("no-rows %d\n", skincad_detector_rest(&detector, volts, 0));
    for (c = 0; c < 3 * SKINCAD_CHANNELS; c++)
        volts[c] = 1.5f;
    skincad_detector_rest(&detector, volts, 3);
    skincad_detector_feed(&detector, volts, 3, alarms, 3 * SKINCAD_MOST_ALARMS);
    before = detector;
    for (i = 0; i < 4; i++) {
        volts[3 * SKINCAD_CHANNELS - 1] = wrong[i];
        printf("refused %d", skincad_detector_feed(&detector, volts, 3, alarms, 3 * SKINCAD_MOST_ALARMS));
        printf(" %d", i < 3 ? skincad_detector_rest(&detector, volts, 3) : -1);
        printf(" %d\n", memcmp(&before, &detector, sizeof detector));
    }
}

/* Of a value that rises slowly beside a rest between 1.65 V and the next float32, for very many samples. */
static void means(long rows)
{
    long i;
    int c, k;
    skincad_detector_init(&detector);
    for (c = 0; c < 2 * SKINCAD_CHANNELS; c++)
        volts[c] = c < SKINCAD_CHANNELS ? 1.65f : nextafterf(1.65f, 2.0f);
    skincad_detector_rest(&detector, volts, 2);
    for (i = 0; i < rows; i++) {
        for (c = 0; c < SKINCAD_CHANNELS; c++)
            volts[c] = 1.65f + (float)(c + 1) * 1e-6f * (float)(i % 4096);
        skincad_detector_feed(&detector, volts, 1, alarms, SKINCAD_MOST_ALARMS);
    }
    for (i = 0; i < KINDS * RIDGES; i++)
        for (k = 0; k < SPANS; k++)
            printf("mean %.9g %.9g\n", (double)detector.mean[i][k], (double)detector.carry[i][k]);
}

int main(int count, char **words)
{
    printf("bytes %lu\n", (unsigned long)sizeof(skincad_detector));
    functions();
    refusals();
    means(count > 1 ? atol(words[1]) : 10);
    return 0;
}

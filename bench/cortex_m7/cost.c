/* How many instructions the detector takes for a sample while all ridges are loud, by QEMU's clock of one tick in so
   many instructions. Prints that, and whether they were loud. */
#include "skincad_detector.h"

#include <stdio.h>

#define TIMER ((volatile uint32_t *)0xE000E010u) /* SysTick: control, reload, value; it counts down */
#define WRAP 0xFFFFFFu
#define ROWS 120
#define MOST (ROWS * SKINCAD_MOST_ALARMS)

static skincad_detector detector;
static skincad_alarm alarms[MOST];
static float volts[ROWS * SKINCAD_CHANNELS];

int main(void)
{
    uint32_t noise = 1, begun, ended, block;
    double ticks = 0.0;
    int i, loud = 1;
    TIMER[1] = WRAP;
    TIMER[2] = 0;
    TIMER[0] = 5; /* on, by the processor's clock */
    skincad_detector_init(&detector);
    for (block = 0; block < 8; block++) {
        for (i = 0; i < ROWS * SKINCAD_CHANNELS; i++) {
            noise = noise * 1664525u + 1013904223u;
            volts[i] = 50.0f * SKINCAD_NOISE_V * ((float)(noise >> 8) / 8388608.0f - 1.0f);
        }
        begun = TIMER[2];
        skincad_detector_feed(&detector, volts, ROWS, alarms, MOST);
        ended = TIMER[2];
        if (block < 4) /* its means rise to the load */
            continue;
        ticks += (double)((begun - ended) & WRAP);
        for (i = 0; i <= SKINCAD_RIDGES; i++)
            loud = loud && detector.odds[i] > SKINCAD_QUIET;
    }
    printf("%.1f %s\n", ticks / (4 * ROWS) * TICK, loud ? "loud" : "quiet");
    return 0;
}

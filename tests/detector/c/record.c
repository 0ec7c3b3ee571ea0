/* Feeds a detector recordings as they come from stdin, and prints their alarms: a line a block, "end" behind each recording.
   A recording: blocks (uint32), and of each its rows (uint32) and their values (float32). The first is at rest. */
#include "skincad_detector.h"

#include <stdio.h>
#include <stdlib.h>

static skincad_detector detector;

static uint32_t word(void)
{
    uint32_t value = 0;
    if (fread(&value, sizeof value, 1, stdin) != 1 && !feof(stdin))
        exit(3);
    return value;
}

int main(void)
{
    uint32_t blocks, block;
    while ((blocks = word()) > 0) {
        skincad_detector_init(&detector);
        for (block = 0; block < blocks; block++) {
            const size_t rows = word(), most = SKINCAD_MOST_ALARMS * (rows / SKINCAD_EVERY + 1);
            float *volts = malloc((rows * SKINCAD_CHANNELS + 1) * sizeof *volts);
            skincad_alarm *alarms = malloc(most * sizeof *alarms);
            int i, count = 0;
            if (volts == NULL || alarms == NULL)
                return 4;
            if (fread(volts, sizeof *volts, rows * SKINCAD_CHANNELS, stdin) != rows * SKINCAD_CHANNELS)
                return 5;
            if (block == 0)
                count = skincad_detector_rest(&detector, volts, rows);
            else
                count = skincad_detector_feed(&detector, volts, rows, alarms, (int)most);
            if (count < 0 || (size_t)count > most)
                return 6;
            for (i = 0; block > 0 && i < count; i++)
                printf("%lu,%d,%d ", (unsigned long)alarms[i].sample, alarms[i].kind, alarms[i].ridge);
            if (block > 0)
                printf("\n");
            free(volts);
            free(alarms);
        }
        printf("end\n");
    }
    return 0;
}

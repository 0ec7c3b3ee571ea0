/* Holds the detector against its test vectors, all rows at once and one by one. Prints what differs; returns 0 if
   nothing does. Build it as README.md says, on a PC or for the board. */
#include "skincad_detector/skincad_detector.h"

#include <math.h>
#include <stdio.h>

#include "test_vectors.h"

#define ODDS_ERROR 1e-3f /* of float32 against Python's double: some 1e-5 */

static skincad_detector detector;
static skincad_alarm alarms[TEST_ALARMS + 1];
static float volts[TEST_ROWS * SKINCAD_CHANNELS];

static void fill(const short *rows, size_t count)
{
    size_t i;
    for (i = 0; i < count; i++)
        volts[i] = (float)rows[i] * TEST_VOLTS;
}

static void begin(void)
{
    fill(test_rest, (size_t)TEST_REST_ROWS * SKINCAD_CHANNELS);
    skincad_detector_init(&detector);
    skincad_detector_rest(&detector, volts, TEST_REST_ROWS);
    fill(test_rows, (size_t)TEST_ROWS * SKINCAD_CHANNELS);
}

static int differing(int count, const char *how)
{
    int i, faults = count != TEST_ALARMS;
    if (faults)
        printf("%s: %d alarms, %d are right\n", how, count, TEST_ALARMS);
    for (i = 0; i < count && i < TEST_ALARMS; i++) {
        const skincad_alarm *is = &alarms[i], *right = &test_alarms[i];
        if (is->sample != right->sample || is->kind != right->kind || is->ridge != right->ridge) {
            printf("%s: alarm %d is sample %lu, %s, ridge %d; sample %lu, %s, ridge %d is right\n", how, i,
                   (unsigned long)is->sample, skincad_alarm_name(is->kind), is->ridge,
                   (unsigned long)right->sample, skincad_alarm_name(right->kind), right->ridge);
            faults++;
        }
    }
    return faults;
}

int main(void)
{
    int faults, count = 0, at = 0, row, place;
    float largest = 0.0f;

    begin();
    faults = differing(skincad_detector_feed(&detector, volts, TEST_ROWS, alarms, TEST_ALARMS + 1), "at once");
    begin();
    for (row = 0; row < TEST_ROWS; row++) {
        const int room = count <= TEST_ALARMS ? TEST_ALARMS + 1 - count : 0;
        count += skincad_detector_feed(&detector, volts + row * SKINCAD_CHANNELS, 1, alarms + TEST_ALARMS + 1 - room, room);
        if (at < TEST_ODDS && test_odds_at[at] == (unsigned)row) {
            for (place = 0; place <= SKINCAD_RIDGES; place++) {
                const float is = detector.odds[place], right = test_odds[at][place];
                const float off = is == SKINCAD_QUIET ? (right > TEST_QUIET + ODDS_ERROR ? 1.0f : 0.0f) : fabsf(is - right);
                if (!(off <= ODDS_ERROR)) {
                    printf("odds %d of sample %d are %g; %g is right\n", place, row, (double)is, (double)right);
                    faults++;
                }
                largest = off > largest ? off : largest;
            }
            at++;
        }
    }
    faults += differing(count, "one by one");
    if (faults == 0)
        printf("passed: %d alarms in %d samples, odds within %.1e\n", TEST_ALARMS, TEST_ROWS, (double)largest);
    else
        printf("failed: %d differ\n", faults);
    return faults != 0;
}

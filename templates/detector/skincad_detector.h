/* Slip felt from the films' outputs: the detector of {{ code.name }}, as skincad {{ version }} wrote it.

   static skincad_detector detector;
   static skincad_alarm alarms[SKINCAD_MOST_ALARMS];
   skincad_detector_init(&detector);
   skincad_detector_rest(&detector, samples, n);
   for (;;) {
       ... fill samples: n rows of SKINCAD_CHANNELS values in V, S1 and S2 of each ridge in their order
       count = skincad_detector_feed(&detector, samples, n, alarms, SKINCAD_MOST_ALARMS);
   }

   C99, float32, nothing is allocated, nothing is static: as many detectors as you have structures. Blocks of any
   size give the same alarms. */
#ifndef SKINCAD_DETECTOR_H
#define SKINCAD_DETECTOR_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SKINCAD_RIDGES {{ code.ridges | length }}
#define SKINCAD_CHANNELS (2 * SKINCAD_RIDGES)
#define SKINCAD_RATE_HZ {{ real(code.rate) }} /* of the samples */
{% if tuning.change is none %}
#define SKINCAD_NOISE_V {{ real(tuning.noise) }} /* rms, of a ridge's S1 - S2 at rest: no alarm below {{ seen | g }} times it */
{% else %}
#define SKINCAD_NOISE_V {{ real(tuning.noise) }} /* rms, of a ridge's S1 - S2 at rest */
#define SKINCAD_CHANGE_V {{ real(tuning.change) }} /* rms, of what that changes by from sample to sample, which the detector
   hears: the outputs are the stress itself, not its rate. No alarm below {{ seen | g }} times it. */
{% endif %}
#define SKINCAD_THRESHOLD {{ real(tuning.threshold) }} /* logarithm of odds from which on a ridge is said to slip */
#define SKINCAD_WARNING {{ real(tuning.warning) }} /* and from which on gross slip is said to be ahead */
#define SKINCAD_EVERY {{ tuning.every }} /* it decides at one of so many samples */
#define SKINCAD_MOST_ALARMS (SKINCAD_RIDGES + 1) /* of SKINCAD_EVERY samples */
#define SKINCAD_QUIET (-1000.0f) /* the odds of what does not stand out of the noise */

enum { SKINCAD_INCIPIENT_SLIP, SKINCAD_GROSS_SLIP_AHEAD };

typedef struct {
    uint32_t sample; /* at which it was raised, from 0; after 2^32 from 0 again */
    int kind;        /* SKINCAD_INCIPIENT_SLIP or SKINCAD_GROSS_SLIP_AHEAD */
    int ridge;       /* number on the skin, from 1; 0 of the whole skin */
} skincad_alarm;

/* All that a detector keeps. Read `odds`, the logarithms of the odds of each ridge's slip and last of gross slip,
   as of the last decision; leave the rest alone. */
typedef struct {
    float rest[2][SKINCAD_CHANNELS];
    float mean[10 * SKINCAD_RIDGES][6];
    float carry[10 * SKINCAD_RIDGES][6];
    float odds[SKINCAD_RIDGES + 1];
    uint32_t count;
    uint32_t since;
    unsigned char taken[SKINCAD_RIDGES + 1];
{% if tuning.change is not none %}
    unsigned char begun;
    float last[SKINCAD_CHANNELS];
{% endif %}
} skincad_detector;

/* Begins anew: no sample heard, a resting voltage of 0 V. */
void skincad_detector_init(skincad_detector *detector);

/* Takes the mean of n rows, heard while nothing touches, off all that follows. Returns 0; or -1 without a row or for a
   value that is not finite, and has changed nothing then. */
int skincad_detector_rest(skincad_detector *detector, const float *samples, size_t n);

/* Hears the next n rows. Returns how many alarms they raised, of which the first `most` are in `alarms`; or -1 for a
   value that is not finite, or 1e9 times the {{ "changes' " if tuning.change is not none }}noise from rest, and has heard nothing then. */
int skincad_detector_feed(skincad_detector *detector, const float *samples, size_t n, skincad_alarm *alarms, int most);

/* Returns "incipient slip" or "gross slip ahead". */
const char *skincad_alarm_name(int kind);

#ifdef __cplusplus
}
#endif
#endif

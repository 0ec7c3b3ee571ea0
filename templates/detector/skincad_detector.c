/* The same as skincad's detector in Python (skincad/detector), in float32. All voltages are in units of the noise. */
#include "skincad_detector.h"

#include <math.h>
#include <string.h>

#include "skincad_weights.h"

#ifdef __FAST_MATH__
#error "without -ffast-math, please: it drops what the running means carry, and tests for numbers that are not finite"
#endif

#define RIDGES SKINCAD_RIDGES
#define LOUDEST 1e9f /* noise rms; squares of squares of more are beyond float32 */
#define SEEN 5.0f    /* noise rms of a window, below which there is no alarm */
#define BACK 1.0f    /* below its threshold a slip has ended */

#ifdef SKINCAD_CHANGE_V
#define HEARD_NOISE_V SKINCAD_CHANGE_V
#else
#define HEARD_NOISE_V SKINCAD_NOISE_V
#endif

#if defined(FP_FAST_FMAF) || defined(__FP_FAST_FMAF)
#define ADDED(sum, a, b) fmaf(a, b, sum) /* one instruction; C99 makes none of a * b + sum */
#else
#define ADDED(sum, a, b) ((sum) + (a) * (b))
#endif

#if defined(__GNUC__)
#define INLINED static inline __attribute__((always_inline))
#else
#define INLINED static inline
#endif

enum { PAIR, SUM, OTHERS, OTHERS_SUM, PAIR_2, SUM_2, OTHERS_2, OTHERS_SUM_2, PAIR_OTHERS, PAIR_SUM, KINDS };
enum { SPANS = 6, LANES = 4 };

/* Within 5e-7 of tanh everywhere: a ratio of polynomials, the best for up to 8; from there on 1. */
static inline float squashed(float x)
{
    const float most = 8.0f;
    const float y = fminf(fmaxf(x, -most), most);
    const float z = y * y;
    float above = ADDED(2.9388261e-3f, 1.13102078e-5f, z);
    float below = ADDED(2.37028245e-4f, 2.42383663e-7f, z);
    above = ADDED(1.29136398e-1f, above, z);
    below = ADDED(2.37638205e-2f, below, z);
    above = ADDED(9.99999344e-1f, above, z);
    below = ADDED(4.62467372e-1f, below, z);
    return y * above / ADDED(1.0f, below, z);
}

/* Within 2e-7 of the natural logarithm, or of as many parts of it, of a normal number above 0. */
static inline float logarithm(float x)
{
    uint32_t bits;
    int32_t power;
    float f, top;
    memcpy(&bits, &x, sizeof bits);
    power = (int32_t)((bits - 0x3F3504F3u) >> 23); /* of 2, to the nearest by ratio; x is above 1 here */
    bits -= (uint32_t)power << 23;
    memcpy(&f, &bits, sizeof f);
    f -= 1.0f;
    top = ADDED(1.61411762e-1f, -1.0224203e-1f, f);
    top = ADDED(-1.71669066e-1f, top, f);
    top = ADDED(1.99102387e-1f, top, f);
    top = ADDED(-2.49805734e-1f, top, f);
    top = ADDED(3.33346903e-1f, top, f);
    top = ADDED(-0.5f, top, f);
    return ADDED(ADDED(f, top, f * f), 6.93147182e-1f, (float)power);
}

void skincad_detector_init(skincad_detector *d)
{
    int i;
    memset(d, 0, sizeof *d);
    for (i = 0; i <= RIDGES; i++)
        d->odds[i] = SKINCAD_QUIET;
}

int skincad_detector_rest(skincad_detector *d, const float *samples, size_t n)
{
    double sums[SKINCAD_CHANNELS] = {0.0};
    size_t i;
    int c;
    if (n == 0)
        return -1;
    for (i = 0; i < n * SKINCAD_CHANNELS; i++)
        if (!isfinite(samples[i]))
            return -1;
    for (i = 0; i < n; i++)
        for (c = 0; c < SKINCAD_CHANNELS; c++)
            sums[c] += (double)samples[i * SKINCAD_CHANNELS + (size_t)c];
    for (c = 0; c < SKINCAD_CHANNELS; c++) { /* in two parts: samples of 1.65 V with microvolts in them lose nothing */
        const double mean = sums[c] / (double)n;
        d->rest[0][c] = (float)mean;
        d->rest[1][c] = (float)(mean - (double)d->rest[0][c]);
    }
    return 0;
}

/* For each ridge the mean of the other ridges' values, without cancellation; 0 for a ridge alone. */
static void of_others(const float *values, float *others)
{
    const float share = RIDGES > 1 ? 1.0f / (float)(RIDGES > 1 ? RIDGES - 1 : 1) : 0.0f;
    float sum = 0.0f;
    int r;
    for (r = 0; r < RIDGES; r++) {
        others[r] = sum;
        sum += values[r];
    }
    sum = 0.0f;
    for (r = RIDGES - 1; r >= 0; r--) {
        others[r] = (others[r] + sum) * share;
        sum += values[r];
    }
}

/* A sample's values by kind, and their running means brought up to it. */
static void hear(skincad_detector *d, const float *sample, float *now)
{
    const float share0 = skincad_share[0], share1 = skincad_share[1], share2 = skincad_share[2];
    const float share3 = skincad_share[3], share4 = skincad_share[4], share5 = skincad_share[5];
    float *mean = d->mean[0], *carry = d->carry[0];
    int r, i;
#ifdef SKINCAD_CHANGE_V
    if (!d->begun) /* nothing has changed by the first sample */
        memcpy(d->last, sample, sizeof d->last);
    d->begun = 1;
#endif
    for (r = 0; r < RIDGES; r++) {
#ifdef SKINCAD_CHANGE_V
        const float one = (sample[2 * r] - d->last[2 * r]) * skincad_per_noise;
        const float two = (sample[2 * r + 1] - d->last[2 * r + 1]) * skincad_per_noise;
#else
        const float one = ((sample[2 * r] - d->rest[0][2 * r]) - d->rest[1][2 * r]) * skincad_per_noise;
        const float two = ((sample[2 * r + 1] - d->rest[0][2 * r + 1]) - d->rest[1][2 * r + 1]) * skincad_per_noise;
#endif
        now[PAIR * RIDGES + r] = one - two;
        now[SUM * RIDGES + r] = one + two;
    }
#ifdef SKINCAD_CHANGE_V
    memcpy(d->last, sample, sizeof d->last);
#endif
    of_others(now + PAIR * RIDGES, now + OTHERS * RIDGES);
    of_others(now + SUM * RIDGES, now + OTHERS_SUM * RIDGES);
    for (i = 0; i < 4 * RIDGES; i++)
        now[PAIR_2 * RIDGES + i] = now[i] * now[i];
    for (r = 0; r < RIDGES; r++) {
        now[PAIR_OTHERS * RIDGES + r] = now[PAIR * RIDGES + r] * now[OTHERS * RIDGES + r];
        now[PAIR_SUM * RIDGES + r] = now[PAIR * RIDGES + r] * now[SUM * RIDGES + r];
    }
    /* mean += share * (now - mean). A slow mean takes steps far below its own last digit: what a step loses there is
       carried to the next (Kahan 1965), which is as good as double, and quick without a double-precision unit. */
#define STEP(k)                                                                    \
    do {                                                                           \
        const float before = mean[k], lost = carry[k];                             \
        const float step = ADDED(lost, share##k, (value - before) - lost);         \
        const float after = before + step;                                         \
        mean[k] = after;                                                           \
        carry[k] = step - (after - before);                                        \
    } while (0)
    for (i = 0; i < KINDS * RIDGES; i++, mean += SPANS, carry += SPANS) {
        const float value = now[i];
        STEP(0); STEP(1); STEP(2); STEP(3); STEP(4); STEP(5);
    }
#undef STEP
}

/* a / sqrt(usual), gently bounded by 4. */
static inline float bounded(float a, float usual)
{
    return a / sqrtf(ADDED(usual, a * a, 0.0625f));
}

/* The value (k = 0) or running mean of a kind. */
static inline float felt(const skincad_detector *d, const float *now, int kind, int k, int r)
{
    return k == 0 ? now[kind * RIDGES + r] : d->mean[kind * RIDGES + r][k - 1];
}

/* A ridge's features, as skincad/detector/features.py has them, into every LANES-th place of x. */
static void features(const skincad_detector *d, const float *now, int r, float *x)
{
#define M(kind, k) felt(d, now, kind, k, r)
#define PUT(value) (*x = (value), x += LANES)
    const float least = 9.0f; /* three noise rms squared */
    const float side = M(PAIR, 5) < 0.0f ? -1.0f : 1.0f;
    float usual[SPANS], level[SPANS + 1], slow, size, load, cone;
    int k, kind, ahead;
    for (k = 3; k <= 5; k++)
        usual[k] = ADDED(M(PAIR_2, k) + least, 0.09f, M(SUM_2, k));

    for (kind = PAIR; kind <= OTHERS_SUM; kind++) {
        const float sign = kind == PAIR || kind == OTHERS ? side : 1.0f;
        for (k = 0; k < 6; k++)
            PUT(bounded(M(kind, k) * sign, usual[4]));
    }
    for (k = 0; k <= 2; k++)
        PUT(bounded(M(PAIR, k) * side, usual[3]));
    PUT(bounded(M(PAIR, 0) * side, usual[5]));
    PUT(bounded(M(PAIR, 2) * side, usual[5]));
    PUT(bounded(M(PAIR, 5) * side, usual[5]));

    for (k = 3; k <= 5; k++) {
        const float follows = M(PAIR_OTHERS, k) / (M(OTHERS_2, k) + least);
        const float tied = M(PAIR_SUM, k) / (M(SUM_2, k) + least);
        int fast;
        for (fast = 0; fast <= 2; fast += 2) {
            PUT(bounded(ADDED(M(PAIR, fast), -follows, M(OTHERS, fast)) * side, usual[k]));
            PUT(bounded(ADDED(M(PAIR, fast), -tied, M(SUM, fast)) * side, usual[k]));
        }
        PUT(bounded(follows, 1.0f));
        PUT(bounded(tied * side, 1.0f));
    }
    slow = M(PAIR, 6);
    size = fabsf(M(SUM, 6)) + 0.03f;
    load = slow / (size + fabsf(slow));
    cone = slow / size;
    PUT(load * side);
    for (k = 0; k <= 3; k += k == 0 ? 2 : 1) {
        const float beyond = ADDED(M(PAIR, k), -cone, M(SUM, k)); /* its square is to be a float32 too */
        PUT(bounded(fminf(fmaxf(beyond, -1e15f), 1e15f) * side, usual[4]));
    }

    for (ahead = 1; ahead >= 0; ahead--) {
        const int beside = (side > 0.0f) == (ahead == 1) ? r + 1 : r - 1;
        const int there = beside >= 0 && beside < RIDGES;
        for (k = 1; k <= 3; k++)
            PUT(there ? bounded(felt(d, now, PAIR, k, beside) * side, usual[4]) : 0.0f);
        for (k = 1; k <= 2; k++)
            PUT(there ? bounded(felt(d, now, SUM, k, beside), usual[4]) : 0.0f);
        PUT(there ? 1.0f : 0.0f);
    }

    for (k = 1; k <= SPANS; k++)
        level[k] = logarithm(M(PAIR_2, k) + least);
    PUT(logarithm(usual[3]) * 0.125f);
    PUT(logarithm(usual[5]) * 0.125f);
    for (k = 1; k <= SPANS; k++)
        if (k != 5)
            PUT((level[k] - level[5]) * 0.25f);
    for (kind = SUM_2; kind <= OTHERS_2; kind++)
        for (k = 1; k <= SPANS; k += k == 1 ? 1 : 2)
            PUT((logarithm(M(kind, k) + least) - level[k]) * 0.25f);
    PUT((logarithm(M(OTHERS_SUM_2, 4) + least) - level[4]) * 0.25f);
#undef M
#undef PUT
}

/* Each hidden unit of both networks for up to LANES ridges: units by UNITS, so that 24 sums, the ridges' features and a
   weight stay in a processor's 32 registers, and each is loaded once for many products. `width` is a constant. */
#define UNITS SKINCAD_UNITS
#define BEGIN(u) float u##0 = bias[0x##u - 0xA], u##1 = u##0, u##2 = u##0, u##3 = u##0
#define TERM(u)                                       \
    do {                                              \
        const float weight = into[0x##u - 0xA];       \
        u##0 = ADDED(u##0, weight, x0);               \
        if (width > 1) u##1 = ADDED(u##1, weight, x1); \
        if (width > 2) u##2 = ADDED(u##2, weight, x2); \
        if (width > 3) u##3 = ADDED(u##3, weight, x3); \
    } while (0)
#define TERMS                                                                 \
    do {                                                                      \
        const float x0 = x[0], x1 = width > 1 ? x[1] : 0.0f;                  \
        const float x2 = width > 2 ? x[2] : 0.0f, x3 = width > 3 ? x[3] : 0.0f; \
        TERM(A); TERM(B); TERM(C); TERM(D); TERM(E); TERM(F);                 \
        x += LANES;                                                           \
        into += UNITS;                                                        \
    } while (0)
#define END(u)                                             \
    do {                                                   \
        hidden[0] = u##0;                                  \
        hidden[1] = u##1;                                  \
        hidden[2] = u##2;                                  \
        hidden[3] = u##3;                                  \
        hidden += LANES;                                   \
    } while (0)

INLINED void networks(const float *felt_by_ridge, const int width, float (*odds)[LANES])
{
    const float *into = skincad_into, *bias = skincad_bias, *out = skincad_out;
    float units[SKINCAD_MOST_HIDDEN * LANES];
    int network, block, f, i, r;
    for (network = 0; network < 2; network++) {
        const int count = skincad_hidden[network];
        float *hidden = units, sums[LANES];
        for (block = 0; block < count / UNITS; block++) {
            const float *x = felt_by_ridge;
            BEGIN(A); BEGIN(B); BEGIN(C); BEGIN(D); BEGIN(E); BEGIN(F);
            for (f = 0; f < SKINCAD_FEATURES; f += 2) {
                TERMS;
                TERMS;
            }
            END(A); END(B); END(C); END(D); END(E); END(F);
            bias += UNITS;
        }
        sums[0] = sums[1] = sums[2] = sums[3] = skincad_base[network];
        for (i = 0; i < count; i++) {
            const float *unit = units + i * LANES, weight = *out++;
            sums[0] = ADDED(sums[0], weight, squashed(unit[0]));
            if (width > 1) sums[1] = ADDED(sums[1], weight, squashed(unit[1]));
            if (width > 2) sums[2] = ADDED(sums[2], weight, squashed(unit[2]));
            if (width > 3) sums[3] = ADDED(sums[3], weight, squashed(unit[3]));
        }
        for (r = 0; r < width; r++)
            odds[network][r] = sums[r];
    }
}

/* Odds of all ridges and of the skin; whether any stands out of the noise. */
static void decide(skincad_detector *d, const float *now)
{
    float x[SKINCAD_FEATURES * LANES], odds[2][LANES], whole = 0.0f;
    int first, r, any = 0;
    for (r = 0; r < RIDGES; r++)
        any |= felt(d, now, PAIR_2, 2, r) > SEEN * SEEN;
    for (r = 0; r <= RIDGES; r++)
        d->odds[r] = SKINCAD_QUIET;
    if (!any)
        return;
    for (first = 0; first < RIDGES; first += LANES) {
        const int width = RIDGES - first < LANES ? RIDGES - first : LANES;
        for (r = 0; r < width; r++)
            features(d, now, first + r, x + r);
        if (RIDGES >= LANES && width == LANES)
            networks(x, LANES, odds);
        else if (RIDGES % LANES > 0)
            networks(x, RIDGES % LANES, odds);
        for (r = 0; r < width; r++) {
            if (felt(d, now, PAIR_2, 2, first + r) > SEEN * SEEN)
                d->odds[first + r] = odds[0][r];
            whole += odds[1][r];
        }
    }
    d->odds[RIDGES] = whole / (float)RIDGES;
}

int skincad_detector_feed(skincad_detector *d, const float *samples, size_t n, skincad_alarm *alarms, int most)
{
    float now[KINDS * RIDGES];
    size_t i;
    int c, place, count = 0;
    for (i = 0; i < n; i++)
        for (c = 0; c < SKINCAD_CHANNELS; c++)
            if (!(fabsf(samples[i * SKINCAD_CHANNELS + (size_t)c] - d->rest[0][c]) <= LOUDEST * HEARD_NOISE_V))
                return -1;
    for (i = 0; i < n; i++, d->count++, samples += SKINCAD_CHANNELS) {
        hear(d, samples, now);
        if (++d->since < SKINCAD_EVERY)
            continue;
        d->since = 0;
        decide(d, now);
        for (place = 0; place <= RIDGES; place++) {
            const float level = place < RIDGES ? SKINCAD_THRESHOLD : SKINCAD_WARNING;
            if (d->odds[place] > level && !d->taken[place]) {
                d->taken[place] = 1;
                if (count < most) {
                    alarms[count].sample = d->count;
                    alarms[count].kind = place < RIDGES ? SKINCAD_INCIPIENT_SLIP : SKINCAD_GROSS_SLIP_AHEAD;
                    alarms[count].ridge = place < RIDGES ? skincad_ridge[place] : 0;
                }
                count++;
            } else if (d->odds[place] < level - BACK) {
                d->taken[place] = 0;
            }
        }
    }
    return count;
}

const char *skincad_alarm_name(int kind)
{
    return kind == SKINCAD_INCIPIENT_SLIP ? "incipient slip" : "gross slip ahead";
}

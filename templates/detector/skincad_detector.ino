// Samples the films of {{ code.name }} on a Teensy 4.1, and prints samples and alarms.
//
// A line a sample, "sample,ridge_..._S1_V,..." first and then once a second, "alarm,SAMPLE,KIND,RIDGE", and remarks after #.
// At the start nothing may touch the skin for a second: its mean is each channel's resting voltage.
#include "skincad_detector.h"

static const uint8_t PINS[] = {A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, A12, A11, A13, A16, A14, A17, A15}; // as an amplifier board's channels.csv
static const char HEADER[] = "sample{% for ridge in code.ridges %},ridge_{{ ridge }}_S1_V,ridge_{{ ridge }}_S2_V{% endfor %}\n";
static const bool INVERTED = {{ "true" if code.inverted else "false" }}; // the amplifier's pin moves against output_V, which the detector hears
static const bool PRINT_SAMPLES = true; // false: alarms and remarks alone
static const int BITS = 12;
static const float VOLTS = 3.3f / (1 << BITS); // of a count

static_assert(SKINCAD_CHANNELS <= sizeof PINS, "a Teensy 4.1 has 18 analogue pins: export fewer ridges");

static const uint32_t RATE = {{ code.rate | round | int }}, ROWS = 256, BLOCK = 32;
static uint16_t ring[ROWS][SKINCAD_CHANNELS]; // of the latest samples, in counts
static volatile uint32_t taken = 0;           // samples since the start
static uint32_t heard = 0, lost = 0, resting = 0;
static IntervalTimer timer;
static skincad_detector detector;
static int64_t sums[SKINCAD_CHANNELS], pairs[SKINCAD_RIDGES], squares[SKINCAD_RIDGES]; // of counts at rest

static void take() {
    uint16_t *row = ring[taken % ROWS];
    for (int c = 0; c < SKINCAD_CHANNELS; c++)
        row[c] = (uint16_t)(INVERTED ? (1 << BITS) - 1 - analogRead(PINS[c]) : analogRead(PINS[c]));
    taken = taken + 1;
}

void setup() {
    Serial.begin(115200); // USB takes no notice of it
    analogReadResolution(BITS);
    analogReadAveraging(1);
    skincad_detector_init(&detector);
    timer.begin(take, {{ real(1e6 / code.rate) }}); // us
}

static char *whole(char *end, uint32_t value, int digits) {
    char turned[10];
    int count = 0;
    do {
        turned[count++] = (char)('0' + value % 10);
        value /= 10;
    } while (value > 0 || count < digits);
    while (count > 0)
        *end++ = turned[--count];
    return end;
}

static void print_sample(uint32_t sample, const uint16_t *row) {
    char line[12 + 9 * SKINCAD_CHANNELS];
    static uint32_t headed = 0u - RATE;
    if (sample - headed >= RATE) {
        headed = sample;
        Serial.write(HEADER, sizeof HEADER - 1);
    }
    char *end = whole(line, sample, 1);
    for (int c = 0; c < SKINCAD_CHANNELS; c++) {
        const uint32_t micro = ((uint32_t)row[c] * 825000u) >> 10; // 3.3 V / 4096 = 825000 / 1024 uV
        *end++ = ',';
        end = whole(end, micro / 1000000u, 1);
        *end++ = '.';
        end = whole(end, micro % 1000000u, 6);
    }
    *end++ = '\n';
    if (Serial.availableForWrite() >= end - line) // else nobody reads fast enough: the line is left out, not the sample
        Serial.write(line, (size_t)(end - line));
}

// The first second: nothing touches. The mean is what channels rest at; S1 - S2 tells how noisy the board is.
static void rest(const uint16_t *row) {
    for (int c = 0; c < SKINCAD_CHANNELS; c++)
        sums[c] += row[c];
    for (int r = 0; r < SKINCAD_RIDGES; r++) {
        const int pair = (int)row[2 * r] - (int)row[2 * r + 1];
        pairs[r] += pair;
        squares[r] += (int64_t)pair * pair;
    }
    if (++resting < RATE)
        return;
    float means[SKINCAD_CHANNELS], noisiest = 1.0f / 6.0f; // counts squared: of rounding alone, twice 1/12
    for (int c = 0; c < SKINCAD_CHANNELS; c++)
        means[c] = (float)((double)sums[c] / RATE * VOLTS);
    skincad_detector_rest(&detector, means, 1);
    for (int r = 0; r < SKINCAD_RIDGES; r++) {
        const double mean = (double)pairs[r] / RATE;
        noisiest = fmaxf(noisiest, (float)((double)squares[r] / RATE - mean * mean));
    }
    const float noise = sqrtf(noisiest) * VOLTS;
    Serial.print("# at rest S1 - S2 has ");
    Serial.print(noise, 6);
    Serial.print(" V rms; the detector was made for ");
    Serial.print(SKINCAD_NOISE_V, 6);
    Serial.print(noise > 1.2f * SKINCAD_NOISE_V ? " V: export it with this as --noise\n" : " V\n");
}

void loop() {
    static float volts[BLOCK * SKINCAD_CHANNELS];
    static skincad_alarm alarms[(BLOCK / SKINCAD_EVERY + 1) * SKINCAD_MOST_ALARMS];
    const uint32_t now = taken;
    if (now - heard > ROWS - BLOCK) { // what was not heard in time is overwritten soon
        lost += now - heard - BLOCK;
        heard = now - BLOCK;
        Serial.print("# samples lost since the start: ");
        Serial.print(lost);
        Serial.print("\n");
    }
    const uint32_t rows = now - heard < BLOCK ? now - heard : BLOCK;
    uint32_t count = 0;
    const uint32_t first = heard;
    for (uint32_t i = 0; i < rows; i++, heard++) {
        const uint16_t *row = ring[heard % ROWS];
        if (PRINT_SAMPLES)
            print_sample(heard, row);
        if (resting < RATE) {
            rest(row);
            continue;
        }
        for (int c = 0; c < SKINCAD_CHANNELS; c++)
            volts[count * SKINCAD_CHANNELS + c] = row[c] * VOLTS;
        count++;
    }
    const uint32_t ahead = first + (rows - count) - detector.count; // of the detector's count of samples
    const int most = sizeof alarms / sizeof alarms[0];
    const int raised = skincad_detector_feed(&detector, volts, count, alarms, most);
    for (int i = 0; i < raised; i++) {
        Serial.print("alarm,");
        Serial.print(alarms[i].sample + ahead);
        Serial.print(",");
        Serial.print(skincad_alarm_name(alarms[i].kind));
        Serial.print(",");
        if (alarms[i].ridge > 0)
            Serial.print(alarms[i].ridge);
        Serial.print("\n");
    }
}

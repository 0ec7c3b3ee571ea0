/* What the detector's networks weigh, for skincad_detector.c alone: {{ features }} features, {{ hidden }} hidden
   units each. First the network of a ridge that slips, then that of gross slip ahead. */
#define SKINCAD_FEATURES {{ features }}
#define SKINCAD_HIDDEN {{ hidden }}
#define SKINCAD_UNITS {{ units }}

static const int skincad_ridge[SKINCAD_RIDGES] = { {{- code.ridges | join(", ") -}} };
static const float skincad_per_noise = {{ real(1 / tuning.noise) }}; /* 1/V */
/* of a sample in the running means */
static const float skincad_share[6] = { {{- lines(shares) | trim -}} };
static const float skincad_base[2] = { {{- lines(base) | trim -}} };
static const float skincad_bias[2 * SKINCAD_HIDDEN] = {
{{ lines(bias) }}
};
static const float skincad_out[2 * SKINCAD_HIDDEN] = {
{{ lines(out) }}
};
/* by {{ units }} units: all their weights of the first feature, of the second, ... */
static const float skincad_into[2 * SKINCAD_HIDDEN * SKINCAD_FEATURES] = {
{{ lines(into) }}
};

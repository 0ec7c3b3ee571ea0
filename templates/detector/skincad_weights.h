/* What the detector's networks weigh, for skincad_detector.c alone: {{ features }} features, {{ hidden | join(" and ") }} hidden
   units. First the network of a ridge that slips, then that of gross slip ahead. */
#define SKINCAD_FEATURES {{ features }}
#define SKINCAD_MOST_HIDDEN {{ hidden | max }}
#define SKINCAD_UNITS {{ units }}

static const int skincad_hidden[2] = { {{- hidden | join(", ") -}} };
static const int skincad_ridge[SKINCAD_RIDGES] = { {{- code.ridges | join(", ") -}} };
static const float skincad_per_noise = {{ real(1 / tuning.noise_floor) }}; /* 1/V */
/* of a sample in the running means */
static const float skincad_share[6] = { {{- lines(shares) | trim -}} };
static const float skincad_base[2] = { {{- lines(base) | trim -}} };
static const float skincad_bias[{{ hidden | sum }}] = {
{{ lines(bias) }}
};
static const float skincad_out[{{ hidden | sum }}] = {
{{ lines(out) }}
};
/* by {{ units }} units: all their weights of the first feature, of the second, ... */
static const float skincad_into[{{ hidden | sum }} * SKINCAD_FEATURES] = {
{{ lines(into) }}
};

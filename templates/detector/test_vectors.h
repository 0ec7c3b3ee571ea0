/* What the detector is to say of some samples, as Python's detector said it; for test_detector.c alone. */
#define TEST_REST_ROWS {{ code.vectors.rest | length }}
#define TEST_ROWS {{ code.vectors.rows | length }}
#define TEST_ALARMS {{ code.vectors.alarms | length }}
#define TEST_ODDS {{ code.vectors.odds | length }}
#define TEST_VOLTS {{ real(code.vectors.volts) }} /* of a step of the inputs */
#define TEST_QUIET {{ real(code.vectors.quiet) }} /* Python gives no higher odds to what is quiet */

static const short test_rest[TEST_REST_ROWS * SKINCAD_CHANNELS] = {
{{ lines(code.vectors.rest.ravel()) }}
};
static const short test_rows[TEST_ROWS * SKINCAD_CHANNELS] = {
{{ lines(code.vectors.rows.ravel()) }}
};
static const skincad_alarm test_alarms[TEST_ALARMS + 1] = {
{% for sample, kind, ridge in code.vectors.alarms %}
    {{ "{" ~ sample ~ ", " ~ ("SKINCAD_GROSS_SLIP_AHEAD" if kind else "SKINCAD_INCIPIENT_SLIP") ~ ", " ~ ridge ~ "}," }}
{% endfor %}
    {0, 0, 0}, /* no alarm: C has no empty arrays */
};
static const unsigned test_odds_at[TEST_ODDS + 1] = {
{% for row in code.vectors.odds %}
    {{ row[0] }},
{% endfor %}
    0,
};
static const float test_odds[TEST_ODDS + 1][SKINCAD_RIDGES + 1] = {
{% for row in code.vectors.odds %}
    { {{- lines(row[1:]) | trim -}} },
{% endfor %}
    {0.0f},
};

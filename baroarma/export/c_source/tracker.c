/* ---- pressure to height --------------------------------------------------------------------------------------
 *
 *     h(p) - h(p_1) = -T0/L (p_1/p_0)^k expm1(k log1p((p - p_1)/p_1)),   k = R L/g       [ISA; SG13, Eq. 4]
 *
 * p_1 is the first sample.  p - p_1 is exact in floating point as long as the two are near each other, where
 * h(p) by itself would only be known to 8 mm in a float. */

static real altitude_of(baroarma_state *state, real pressure)
{
    if (!(pressure > 0 && isfinite(pressure))) return NO_SAMPLE;
    if (isnan(state->first_pressure)) {
        state->first_pressure = pressure;
        state->metres
            = BAROARMA_SCALE_HEIGHT * EXP(BAROARMA_EXPONENT * LOG(pressure / BAROARMA_SEA_LEVEL_PRESSURE));
    }
    return -state->metres
        * EXPM1(BAROARMA_EXPONENT * LOG1P((pressure - state->first_pressure) / state->first_pressure));
}

/* ---- alignment: what the rest at the start says about tilt, gyro bias, gravity and the zero of height ---- */

static void alignment_start(baroarma_alignment *s)
{
    const baroarma_alignment nothing = {0};
    *s = nothing;
}

static void take_mean(real *mean, int count, real value)
{
    *mean += (value - *mean) / (real)count;
}

/* Mean and spread of the vectors so far. */
static void take_spread(real mean[3], real *spread, int count, const real v[3])
{
    int i;
    for (i = 0; i < 3; i++) {
        const real off = v[i] - mean[i];
        take_mean(&mean[i], count, v[i]);
        *spread += off * (v[i] - mean[i]);
    }
}

static void align_force(baroarma_alignment *s, baroarma_part *part, const real accel[3])
{
    const real modulus = SQRT(dot(accel, accel));
    take_spread(s->force, &s->force_spread, ++s->forces, accel);
    take_mean(&s->modulus, s->forces, modulus);
    take_mean(&part->modulus, ++part->forces, modulus);
}

static void align_rate(baroarma_alignment *s, baroarma_part *part, const real gyro[3])
{
    int i;
    take_spread(s->rate, &s->rate_spread, ++s->rates, gyro);
    part->rates++;
    for (i = 0; i < 3; i++) take_mean(&part->rate[i], part->rates, gyro[i]);
}

static void align(baroarma_state *state, const real accel[3], const real gyro[3], real altitude, real dt)
{
    baroarma_alignment *s = &state->alignment;
    const int now = (int)(s->elapsed.time * BAROARMA_PARTS + BAROARMA_PART_ROUNDING);
    baroarma_part *part = &s->parts[now < BAROARMA_PARTS ? now : BAROARMA_PARTS - 1];
    early_take(&state->early, s->samples > 0 ? dt : 0, altitude);
    s->samples++;
    if (is_sample(accel)) align_force(s, part, accel);
    if (is_rate(gyro)) align_rate(s, part, gyro);
    if (isnan(altitude)) return;
    take_mean(&s->altitude, ++s->altitudes, altitude);
    conditioning_step(&state->conditioning, altitude);
}

/* The sd of one sample and axis; NaN where too few tell it. */
static real sample_sd(real spread, int count)
{
    return count < BAROARMA_ENOUGH_SAMPLES ? NO_SAMPLE : SQRT(spread / (real)(3 * (count - 1)));
}

/* The sd of the mean of the second, from how the means of its parts differ; n is how many have samples. */
static real mean_sd(const real *means, int n)
{
    real mean = 0, spread = 0;
    int i;
    for (i = 0; i < n; i++) {
        const real off = means[i] - mean;
        take_mean(&mean, i + 1, means[i]);
        spread += off * (means[i] - mean);
    }
    return n < BAROARMA_PARTS ? NO_SAMPLE : SQRT(spread / (real)(n - 1) / (real)n);
}

static real gravity_sd(const baroarma_alignment *s)
{
    real means[BAROARMA_PARTS];
    int i, n = 0;
    for (i = 0; i < BAROARMA_PARTS; i++) {
        if (s->parts[i].forces > 0) means[n++] = s->parts[i].modulus;
    }
    return s->forces < BAROARMA_ENOUGH_SAMPLES ? NO_SAMPLE : mean_sd(means, n);
}

/* The root mean square over the three axes. */
static real gyro_bias_sd(const baroarma_alignment *s)
{
    real sum = 0;
    int axis, i;
    for (axis = 0; axis < 3; axis++) {
        real means[BAROARMA_PARTS];
        int n = 0;
        for (i = 0; i < BAROARMA_PARTS; i++) {
            if (s->parts[i].rates > 0) means[n++] = s->parts[i].rate[axis];
        }
        sum += square(mean_sd(means, n));
    }
    return s->rates < BAROARMA_ENOUGH_SAMPLES ? NO_SAMPLE : SQRT(sum / 3);
}

/* What the second has told; 0 if there was no IMU or no gravity in it. */
static int conclude(const baroarma_alignment *s, baroarma_rest *rest)
{
    const real modulus = SQRT(dot(s->force, s->force));
    int i;
    if (s->forces == 0 || s->rates == 0 || modulus < BAROARMA_LEAST_GRAVITY) return 0;
    for (i = 0; i < 3; i++) {
        rest->up[i] = s->force[i] / modulus;
        rest->gyro_bias[i] = s->rate[i];
    }
    rest->gravity = s->modulus;
    rest->accel_sd = sample_sd(s->force_spread, s->forces);
    rest->gyro_sd = sample_sd(s->rate_spread, s->rates);
    rest->gravity_sd = gravity_sd(s);
    rest->gyro_bias_sd = gyro_bias_sd(s);
    return 1;
}

/* Start the estimators; 0 if the alignment failed. */
static int align_end(baroarma_state *state, real dt)
{
    baroarma_rest rest;
    if (!conclude(&state->alignment, &rest)) return 0;
    attitude_start(&state->attitude, &rest);
    height_start(&state->height, &rest);
    height_look_back(&state->height, &state->early, dt);
    stillness_start(&state->stillness, &rest);
    if (BAROARMA_BIAS_CAPTURE) {
        state->zero = state->alignment.altitude;
        conditioning_shift(&state->conditioning, state->zero);
    }
    return 1;
}

/* ---- the chain: IMU -> attitude -> vertical acceleration -> height <- conditioning <- altitude ------------- */

/* No sensor reads more than this; such a value, or an infinite one, is no sample. */
static void take_vector(real v[3], const real *given, real largest)
{
    int i, good = given != NULL;
    for (i = 0; i < 3; i++) good = good && FABS(given[i]) <= largest;
    for (i = 0; i < 3; i++) v[i] = good ? given[i] : NO_SAMPLE;
}

/* The sd in m/s^2 that an acceleration held over dt must have for the velocity to wander unseen `since`. */
static real unseen_sd(real since, real dt)
{
    const real least = BAROARMA_LEAST_STEP;
    return BAROARMA_UNSEEN_WALK * SQRT(since > least ? since : least) / (dt > least ? dt : least);
}

static int height_is_finite(const baroarma_height *s)
{
    baroarma_result r;
    height_tell(s, &r);
    return isfinite(r.height) && isfinite(r.velocity) && isfinite(r.height_sd) && isfinite(r.velocity_sd);
}

/* One sample; 0 if a number has become too large. */
static int chain_step(baroarma_state *state, const real accel[3], const real gyro[3], real altitude, real dt)
{
    const real since = state->aligned ? dt : 0; /* the attitude's first step takes no time */
    real up[3], a = attitude_step(&state->attitude, since, accel, gyro, up), z = NO_SAMPLE;
    real sd = stillness_step(&state->stillness, dt, accel, gyro);
    const int felt = state->age.time <= BAROARMA_UNFELT;
    int feels;
    if (!isfinite(up[0] + up[1] + up[2]) || isinf(a)) return 0;
    if (FABS(altitude - state->zero) <= BAROARMA_FARTHEST) {
        z = conditioning_step(&state->conditioning, altitude - state->zero);
    }
    tick(&state->age, dt);
    if (!isnan(a)) set_clock(&state->age, 0);
    feels = state->age.time <= BAROARMA_UNFELT;
    if (!feels || dt > BAROARMA_STALE) sd = unseen_sd(felt && !feels ? state->age.time : dt, dt);
    if (!feels) a = 0;
    height_step(&state->height, dt, z, a, sd, up, is_still(&state->stillness));
    if (!isnan(a)) state->acceleration = a;
    return height_is_finite(&state->height);
}

static baroarma_result result_of(const baroarma_state *state, baroarma_status status)
{
    baroarma_result result;
    height_tell(&state->height, &result);
    result.acceleration = state->acceleration;
    result.status = status;
    return result;
}

void baroarma_init(baroarma_state *state)
{
    const baroarma_rest unknown = {{0, 0, 1}, {0, 0, 0}, 0, NO_SAMPLE, NO_SAMPLE, NO_SAMPLE, NO_SAMPLE};
    state->aligned = 0;
    state->first_pressure = NO_SAMPLE;
    state->metres = state->zero = state->acceleration = 0;
    set_clock(&state->age, 0);
    early_start(&state->early);
    alignment_start(&state->alignment);
    conditioning_start(&state->conditioning);
    height_start(&state->height, &unknown);
}

/* The second of rest: collect; at its end, start the estimators, or begin again. */
static baroarma_status align_step(baroarma_state *state, const real accel[3], const real gyro[3], real pressure,
                                  real dt)
{
    baroarma_status status = BAROARMA_ALIGNING;
    real altitude = altitude_of(state, pressure);
    if (state->alignment.samples > 0) tick(&state->alignment.elapsed, dt);
    if (state->alignment.elapsed.time + BAROARMA_CLOCK >= 1) {
        if (align_end(state, dt)) {
            const int good = chain_step(state, accel, gyro, altitude, dt);
            state->aligned = 1;
            return good ? BAROARMA_OK : BAROARMA_OVERFLOW;
        }
        status = BAROARMA_NO_REST;
        baroarma_init(state);
        altitude = altitude_of(state, pressure);
    }
    align(state, accel, gyro, altitude, dt);
    return status;
}

baroarma_result baroarma_step(baroarma_state *state, const real accel[3], const real gyro[3], real pressure,
                              real dt)
{
    baroarma_status status = BAROARMA_OK;
    real force[3], rate[3];
    if (state->alignment.samples > 0 && !(dt >= 0 && dt <= BAROARMA_LONGEST_STEP)) {
        return result_of(state, BAROARMA_BAD_INTERVAL);
    }
    take_vector(force, accel, BAROARMA_LARGEST_FORCE);
    take_vector(rate, gyro, BAROARMA_LARGEST_RATE);
    if (!state->aligned) {
        status = align_step(state, force, rate, pressure, dt);
    } else if (!chain_step(state, force, rate, altitude_of(state, pressure), dt)) {
        status = BAROARMA_OVERFLOW;
    }
    if (status == BAROARMA_OVERFLOW) baroarma_init(state);
    return result_of(state, status);
}

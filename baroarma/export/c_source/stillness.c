/* ---- does the IMU feel anything? ---------------------------------------------------------------------------
 *
 * A quiet period has a reference, the mean specific force since it began.  A knock, a shift of the mean over a
 * tenth of a second, or a reference that is not as long as gravity disturbs it, and begins a new one.  After
 * BAROARMA_SETTLED seconds the IMU is still, which is not to say at rest: so is a lift at constant speed. */

/* The noise of a rest, unless it was none. */
static real noise_of(real sd, real usual, real most)
{
    return isnan(sd) ? usual : smaller(sd, most);
}

static void stillness_start(baroarma_stillness *s, const baroarma_rest *rest)
{
    int i;
    s->accel_sd = noise_of(rest->accel_sd, BAROARMA_USUAL_NOISE[0], BAROARMA_LARGEST_NOISE[0]);
    s->gyro_sd = noise_of(rest->gyro_sd, BAROARMA_USUAL_NOISE[1], BAROARMA_LARGEST_NOISE[1]);
    s->gravity = rest->gravity;
    for (i = 0; i < 3; i++) {
        s->reference[i] = s->force[i] = s->last[i] = rest->gravity * rest->up[i];
        s->rate[i] = 0;
        s->bias[i] = rest->gyro_bias[i];
    }
    s->shaking = square(s->accel_sd);
    set_clock(&s->age, BAROARMA_ALIGNED); /* the alignment has settled already */
    set_clock(&s->silence, 0);
    s->begun = 1;
}

static real distance(const real a[3], const real b[3])
{
    return SQRT(square(a[0] - b[0]) + square(a[1] - b[1]) + square(a[2] - b[2]));
}

/* spread: noise of a short mean, and of the reference, in samples. */
static int disturbs(const baroarma_stillness *s, const real accel[3], const real gyro[3], real spread)
{
    const real shift = BAROARMA_SHIFT * spread, swing = SQRT(dot(s->rate, s->rate));
    return distance(accel, s->reference) > larger(BAROARMA_LEAST_KNOCK[0], BAROARMA_KNOCK * s->accel_sd)
        || distance(s->force, s->reference) > larger(BAROARMA_LEAST_SHIFT[0], shift * s->accel_sd)
        || distance(gyro, s->bias) > larger(BAROARMA_LEAST_KNOCK[1], BAROARMA_KNOCK * s->gyro_sd)
        || swing > larger(BAROARMA_LEAST_SHIFT[1], shift * s->gyro_sd)
        || FABS(SQRT(dot(s->reference, s->reference)) - s->gravity) > BAROARMA_GRAVITY_ERROR;
}

static void begin_period(baroarma_stillness *s, const real accel[3], const real gyro[3])
{
    int i;
    for (i = 0; i < 3; i++) {
        s->reference[i] = s->force[i] = accel[i];
        s->rate[i] = gyro[i] - s->bias[i];
    }
    set_clock(&s->age, 0);
    s->begun = 1;
}

/* Go on with a period; 0 if the sample disturbs it. */
static int extend_period(baroarma_stillness *s, real dt, const real accel[3], const real gyro[3])
{
    const real share = dt / (BAROARMA_SHORT_MEAN + dt);
    const real part = s->age.time > 0 ? dt / smaller(s->age.time, BAROARMA_LONGEST_MEAN) : 0;
    int i;
    for (i = 0; i < 3; i++) {
        s->force[i] += share * (accel[i] - s->force[i]);
        s->rate[i] += share * (gyro[i] - s->bias[i] - s->rate[i]);
    }
    if (disturbs(s, accel, gyro, SQRT(share / (2 - share) + part))) return 0;
    for (i = 0; i < 3; i++) s->reference[i] += part * (accel[i] - s->reference[i]);
    return 1;
}

static int has_settled(const baroarma_stillness *s)
{
    return s->age.time >= BAROARMA_SETTLED - BAROARMA_ROUNDING;
}

static int is_silent(const baroarma_stillness *s)
{
    return s->silence.time > BAROARMA_LONGEST_SILENCE + BAROARMA_ROUNDING;
}

static int is_still(const baroarma_stillness *s)
{
    return has_settled(s) && !is_silent(s);
}

/* White noise, as the accelerometer sees it, of what shakes: from the differences of successive samples. */
static void take_shaking(baroarma_stillness *s, const real accel[3])
{
    const real share = smaller(s->silence.time / BAROARMA_SHAKING_TIME, 1);
    if (has_settled(s)) {
        s->shaking += share * (square(distance(accel, s->last)) / 6 - s->shaking);
    }
}

/* Take a sample; the sd of one specific force where something shakes, m/s^2, NaN: no more than its own. */
static real stillness_step(baroarma_stillness *s, real dt, const real accel[3], const real gyro[3])
{
    int i, silent;
    tick(&s->age, dt);
    tick(&s->silence, dt);
    silent = is_silent(s);
    if (is_sample(accel) && is_rate(gyro)) {
        if (!s->begun || silent || !extend_period(s, dt, accel, gyro)) begin_period(s, accel, gyro);
        take_shaking(s, accel);
        set_clock(&s->silence, 0);
        for (i = 0; i < 3; i++) s->last[i] = accel[i];
    } else if (silent) {
        set_clock(&s->age, 0);
        s->begun = 0;
    }
    return s->shaking > square(BAROARMA_SHAKEN * s->accel_sd) ? SQRT(s->shaking) : NO_SAMPLE;
}

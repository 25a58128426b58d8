/* ---- attitude: Lee's tilt filter ------------------------------------------------------------------------
 *
 * State Z: the vertical in body axes; a: the external acceleration.
 *
 *     Z = exp(-dt [w x]) Z-,   Q = (dt sd_G)^2 (|Z|^2 I - Z Z')                    [Lee16, Eqs. 3, 6a]
 *     f - c_a a- = g Z + noise,   R = (c_a^2/3) |a-|^2 + sd_A^2                    [Lee16, Eqs. 4, 6b]
 *     a = f - g Z
 */

/* The exponential of -dt [w x], or its first two terms as the paper prints them. */
static void fill_transition(real F[3][3], const real rate[3], real dt)
{
    const real p = rate[0], q = rate[1], r = rate[2], speed = SQRT(dot(rate, rate));
    real s = dt, c = 0;
    if (BAROARMA_EXPONENTIAL && speed > 0) {
        s = SIN(speed * dt) / speed;
        c = 2 * square(SIN(speed * dt / 2) / speed);
    }
    F[0][0] = 1 - c * (q * q + r * r);
    F[0][1] = s * r + c * p * q;
    F[0][2] = -s * q + c * p * r;
    F[1][0] = -s * r + c * p * q;
    F[1][1] = 1 - c * (p * p + r * r);
    F[1][2] = s * p + c * q * r;
    F[2][0] = s * q + c * p * r;
    F[2][1] = -s * p + c * q * r;
    F[2][2] = 1 - c * (p * p + q * q);
}

/* variance (|Z|^2 I - Z Z'): errors that turn Z and do not stretch it. */
static void fill_turn(real Q[3][3], const real Z[3], real variance)
{
    const real length = dot(Z, Z);
    int i, j;
    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++) Q[i][j] = -variance * Z[i] * Z[j];
        Q[i][i] += variance * length;
    }
}

static void attitude_start(baroarma_attitude *s, const baroarma_rest *rest)
{
    int i;
    for (i = 0; i < 3; i++) {
        s->up[i] = rest->up[i];
        s->external[i] = 0;
    }
    fill_turn(s->P, s->up, square(BAROARMA_INITIAL_TILT_SD));
    s->gravity = rest->gravity;
    hold_nothing(&s->held, rest->gyro_bias);
}

/* After a long gap of the gyro the specific force gives the tilt anew; free fall has no vertical. */
static void level(baroarma_attitude *s, const real accel[3])
{
    int i;
    if (!has_vertical(accel)) return;
    for (i = 0; i < 3; i++) s->up[i] = accel[i];
    normalise(s->up, 3);
    fill_turn(s->P, s->up, square(BAROARMA_LEVELLING_SD));
    s->held.age = 0;
}

static void correct(baroarma_attitude *s, const real accel[3])
{
    const real c = BAROARMA_ACCELERATION_MEMORY;
    const real r = c * c / 3 * dot(s->external, s->external) + square(BAROARMA_ACCEL_NOISE_SD);
    int i;
    for (i = 0; i < 3; i++) {
        real h[3] = {0};
        h[i] = s->gravity;
        attitude_update(s->up, s->P, h, accel[i] - c * s->external[i] - s->gravity * s->up[i], r);
    }
}

/* The vertical acceleration, m/s^2; NaN without an accelerometer sample.  `up` becomes the vertical. */
static real attitude_step(baroarma_attitude *s, real dt, const real accel[3], const real gyro[3], real up[3])
{
    real F[3][3], Q[3][3], vertical = NO_SAMPLE;
    const int lost = forget_rate(&s->held, dt);
    int i;
    fill_transition(F, s->held.rate, dt);
    fill_turn(Q, s->up, square(dt * BAROARMA_GYRO_NOISE_SD));
    attitude_predict(s->up, s->P, F, Q);
    if (is_sample(accel)) {
        if (lost) {
            level(s, accel);
        } else {
            correct(s, accel);
        }
    }
    normalise(s->up, 3);
    for (i = 0; i < 3; i++) up[i] = s->up[i];
    if (is_sample(accel)) {
        for (i = 0; i < 3; i++) s->external[i] = accel[i] - s->gravity * s->up[i];
        vertical = dot(accel, s->up) - s->gravity;
    }
    take_rate(&s->held, gyro);
    return vertical;
}

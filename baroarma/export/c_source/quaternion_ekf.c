/* ---- attitude: the quaternion filter of Sabatini and Genovese ---------------------------------------------
 *
 * State (q, b): quaternion body -> world, scalar last, and accelerometer bias.
 *
 *     q = exp(dt/2 Omega(w)) q-,   b = exp(-alpha dt) b- + noise                      [SG14, Eqs. 2-8]
 *     f = g up(q) + b + noise; components beyond the gate are left out                [SG14, Eqs. 16, 17]
 */

/* The vertical in body axes: the last row of C^nb [SG14, Eq. 23, sign corrected]. */
static void fill_up(real up[3], const real q[4])
{
    up[0] = 2 * (q[0] * q[2] - q[1] * q[3]);
    up[1] = 2 * (q[1] * q[2] + q[0] * q[3]);
    up[2] = 1 - 2 * (q[0] * q[0] + q[1] * q[1]);
}

/* d up/d q [SG14, Eq. 18]. */
static void fill_up_jacobian(real J[3][4], const real q[4])
{
    J[0][0] = 2 * q[2];
    J[0][1] = -2 * q[3];
    J[0][2] = 2 * q[0];
    J[0][3] = -2 * q[1];
    J[1][0] = 2 * q[3];
    J[1][1] = 2 * q[2];
    J[1][2] = 2 * q[1];
    J[1][3] = 2 * q[0];
    J[2][0] = -4 * q[0];
    J[2][1] = -4 * q[1];
    J[2][2] = 0;
    J[2][3] = 0;
}

/* variance (I - q q') into q's block of P and 0 beside it: errors that turn q and do not stretch it. */
static void fill_turn_covariance(real P[7][7], const real q[4], real variance)
{
    int i, j;
    for (i = 0; i < 4; i++) {
        for (j = 0; j < 7; j++) P[i][j] = P[j][i] = 0;
    }
    for (i = 0; i < 4; i++) {
        for (j = 0; j < 4; j++) P[i][j] = -variance * q[i] * q[j];
        P[i][i] += variance;
    }
}

static void attitude_start(baroarma_attitude *s, const baroarma_rest *rest)
{
    int i, j;
    for (i = 0; i < 7; i++) {
        s->x[i] = 0;
        for (j = 0; j < 7; j++) s->P[i][j] = 0;
        s->P[i][i] = square(BAROARMA_INITIAL_BIAS_SD);
    }
    fill_level(s->x, rest->up);
    fill_turn_covariance(s->P, s->x, square(BAROARMA_INITIAL_QUATERNION_SD));
    s->gravity = rest->gravity;
    hold_nothing(&s->held, rest->gyro_bias);
}

static void fill_transition(real F[7][7], const real rate[3], real dt)
{
    const real speed = SQRT(dot(rate, rate)), c = COS(speed * dt / 2);
    const real half = speed > 0 ? SIN(speed * dt / 2) / speed : dt / 2;
    const real p = half * rate[0], q = half * rate[1], r = half * rate[2];
    const real turn[4][4] = {{c, r, -q, p}, {-r, c, p, q}, {q, -p, c, r}, {-p, -q, -r, c}};
    int i, j;
    for (i = 0; i < 7; i++) {
        for (j = 0; j < 7; j++) F[i][j] = i < 4 && j < 4 ? turn[i][j] : 0;
    }
    F[4][4] = F[5][5] = F[6][6] = decay(BAROARMA_BIAS_DECAY, dt);
}

/* Process noise from the last updated x and P [SG14, Eqs. 7, 11, 12]. */
static void fill_noise(real Q[7][7], const real x[7], real P[7][7], real dt)
{
    const real angle = square(BAROARMA_GYRO_NOISE_SD * dt / 2), alpha = BAROARMA_BIAS_DECAY;
    const real time = alpha > 0 ? -EXPM1(-2 * alpha * dt) / (2 * alpha) : dt;
    real trace = 0;
    int i, j;
    for (i = 0; i < 4; i++) trace += x[i] * x[i] + P[i][i];
    for (i = 0; i < 7; i++) {
        for (j = 0; j < 7; j++) Q[i][j] = i < 4 && j < 4 ? -(x[i] * x[j] + P[i][j]) * angle : 0;
        Q[i][i] += i < 4 ? trace * angle : time * square(BAROARMA_BIAS_WALK_SD);
    }
}

/* After a long gap of the gyro the specific force gives the tilt anew; free fall has no vertical. */
static void level(baroarma_attitude *s, const real accel[3])
{
    if (!has_vertical(accel)) return;
    fill_level(s->x, accel);
    fill_turn_covariance(s->P, s->x, square(BAROARMA_INITIAL_QUATERNION_SD));
    s->held.age = 0;
}

/* The update with all components at once, taken one after the other: H and the gate are those of the
 * prediction, so that each innovation refers to the linearised model there. */
static void correct(baroarma_attitude *s, const real accel[3])
{
    real up[3], J[3][4], predicted[7];
    int c, i;
    fill_up(up, s->x);
    fill_up_jacobian(J, s->x);
    for (i = 0; i < 7; i++) predicted[i] = s->x[i];
    for (c = 0; c < 3; c++) {
        real h[7] = {0}, y = accel[c] - s->gravity * up[c] - predicted[4 + c];
        if (FABS(y) > BAROARMA_GATE) continue;
        h[4 + c] = 1;
        y += predicted[4 + c] - s->x[4 + c];
        for (i = 0; i < 4; i++) {
            h[i] = s->gravity * J[c][i];
            y += h[i] * (predicted[i] - s->x[i]);
        }
        attitude_update(s->x, s->P, h, y, square(BAROARMA_ACCEL_NOISE_SD));
    }
    normalise(s->x, 4);
}

/* The vertical acceleration, m/s^2; NaN without an accelerometer sample.  `up` becomes the vertical. */
static real attitude_step(baroarma_attitude *s, real dt, const real accel[3], const real gyro[3], real up[3])
{
    real F[7][7], Q[7][7];
    const int lost = forget_rate(&s->held, dt);
    fill_transition(F, s->held.rate, dt);
    fill_noise(Q, s->x, s->P, dt);
    attitude_predict(s->x, s->P, F, Q);
    if (is_sample(accel)) {
        if (lost) {
            level(s, accel);
        } else {
            correct(s, accel);
        }
    }
    take_rate(&s->held, gyro);
    fill_up(up, s->x);
    return is_sample(accel) ? dot(accel, up) - s->gravity : NO_SAMPLE;
}

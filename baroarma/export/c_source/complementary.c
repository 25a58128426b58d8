/* ---- height: the complementary filter ---------------------------------------------------------------------
 *
 *     h += dt v + (K_1 + w/2 K_2) w (z - h) + dt^2/2 a,   v += K_2 w (z - h) + dt a    [SG14, Eq. 24]
 *     K = [sqrt(2 sigma_w/sigma_v), sigma_w/sigma_v]                                   [SG14, Eq. 25]
 *
 * A new sample z is used once, with the weight w of the time since the one before.  The sds are those of the
 * filter's own error, propagated with the states of the altimeter's noise. */

#define STATES 5

/* The gains are constants: the noise at rest has no effect. */
static void height_start(baroarma_height *s, const baroarma_rest *rest)
{
    int i, j;
    (void)rest;
    for (i = 0; i < STATES; i++) {
        for (j = 0; j < STATES; j++) s->P[i][j] = 0;
        s->P[i][i] = BAROARMA_INITIAL_VARIANCE[i];
    }
    s->x[0] = s->x[1] = s->low = 0;
    s->sample = NO_SAMPLE;
    s->since = 0;
    s->unused = s->started = 0;
    drive_start(&s->drive);
}

/* P = A P A'. */
static void sandwich(real A[STATES][STATES], real P[STATES][STATES])
{
    real AP[STATES][STATES] = {{0}};
    int i, j, k;
    for (i = 0; i < STATES; i++) {
        for (k = 0; k < STATES; k++) {
            if (!(FABS(A[i][k]) > 0)) continue;
            for (j = 0; j < STATES; j++) AP[i][j] += A[i][k] * P[k][j];
        }
    }
    for (i = 0; i < STATES; i++) {
        for (j = 0; j < STATES; j++) P[i][j] = 0;
    }
    for (j = 0; j < STATES; j++) {
        for (k = 0; k < STATES; k++) {
            if (!(FABS(A[j][k]) > 0)) continue;
            for (i = 0; i < STATES; i++) P[i][j] += AP[i][k] * A[j][k];
        }
    }
}

static void fill_identity(real A[STATES][STATES])
{
    int i, j;
    for (i = 0; i < STATES; i++) {
        for (j = 0; j < STATES; j++) A[i][j] = i == j;
    }
}

/* Propagate the covariance of the error by one step with the gains g. */
static void spread(real P[STATES][STATES], real g_h, real g_v, real dt, real acceleration_variance)
{
    real A[STATES][STATES], phi = decay(BAROARMA_DECAY_RATE, dt);
    fill_identity(A);
    A[0][0] = 1 - g_h;
    A[0][1] = dt;
    A[0][4] = g_h;
    A[1][0] = -g_v;
    A[1][4] = g_v;
    A[2][2] = phi;
    sandwich(A, P);
    P[0][0] += acceleration_variance * square(dt * dt) / 4;
    P[0][1] += acceleration_variance * dt * dt * dt / 2;
    P[1][0] += acceleration_variance * dt * dt * dt / 2;
    P[1][1] += acceleration_variance * dt * dt;
    P[2][2] += BAROARMA_STATIONARY_VARIANCE * (1 - phi * phi);
    P[3][3] += BAROARMA_WALK_VARIANCE * dt;
}

static void advance(baroarma_height *s, real dt, real a, real acceleration_variance)
{
    const real *K = BAROARMA_GAIN;
    real weight = 0, residual = 0, g_h, g_v;
    s->since += dt;
    if (s->unused) {
        weight = s->since < BAROARMA_LONGEST_WEIGHT ? s->since : BAROARMA_LONGEST_WEIGHT;
        residual = s->sample - s->x[0];
        s->unused = 0;
        s->since = 0;
    }
    g_h = (K[0] + weight / 2 * K[1]) * weight;
    g_v = K[1] * weight;
    climb(&s->x[0], &s->low, dt * s->x[1] + g_h * residual + dt * dt / 2 * a);
    s->x[1] += g_v * residual + dt * a;
    spread(s->P, g_h, g_v, dt, acceleration_variance);
}

static void stop(baroarma_height *s)
{
    int i;
    s->x[1] = 0;
    for (i = 0; i < STATES; i++) s->P[1][i] = s->P[i][1] = 0;
    s->P[1][1] = square(BAROARMA_REST_SD);
}

/* A new sample has the noise of now: Gauss-Markov, drift, white. */
static void take_altitude(baroarma_height *s, real altitude)
{
    real A[STATES][STATES];
    fill_identity(A);
    A[4][2] = 1;
    A[4][3] = 1;
    A[4][4] = 0;
    sandwich(A, s->P);
    s->P[4][4] += BAROARMA_WHITE_VARIANCE;
    s->sample = altitude;
    s->unused = 1;
}

/* altitude, m: NaN without a new sample; its acceleration's sd, m/s^2: NaN for the filter's own.  What the IMU
 * feels at rest has no effect here. */
static void height_step(baroarma_height *s, real dt, real altitude, real acceleration, real acceleration_sd,
                        const real up[3], int still)
{
    const real a = drive_step(&s->drive, acceleration);
    const real sd = isnan(acceleration_sd) ? BAROARMA_ACCELERATION_SD : acceleration_sd;
    (void)up;
    (void)still;
    if (s->started && dt > 0) advance(s, dt, a, square(sd));
    s->started = 1;
    if (at_rest(&s->drive)) stop(s);
    if (!isnan(altitude)) take_altitude(s, altitude);
}

static void height_tell(const baroarma_height *s, baroarma_result *result)
{
    result->height = s->x[0];
    result->velocity = s->x[1];
    result->height_sd = root_of(s->P[0][0]);
    result->velocity_sd = root_of(s->P[1][1]);
}

/* ---- the Kalman height filter's steps --------------------------------------------------------------------- */

#define STATES BAROARMA_STATES

/* accel_sd: noise of an accelerometer sample at rest, m/s^2; NaN: not known. */
static void height_start(baroarma_height *s, real accel_sd)
{
    int i, j;
    for (i = 0; i < STATES; i++) {
        s->x[i] = 0;
        for (j = 0; j < STATES; j++) s->P[i][j] = 0;
        s->P[i][i] = BAROARMA_INITIAL_VARIANCE[i];
    }
    s->low = s->doubted = s->jump = 0;
    s->outliers = s->started = 0;
    drive_start(&s->drive);
    fill_model(s, 0);
    start_model(s, accel_sd);
}

/* x = F x + B a,  P = F P F' + wander + variance B B',  B = [dt^2/2, dt, 0 ...]'; zeros of F are skipped. */
static void height_predict(baroarma_height *s, real a, real variance)
{
    const real B[2] = {s->dt * s->dt / 2, s->dt};
    real FP[STATES][STATES] = {{0}}, x[STATES] = {0};
    int i, j, k;
    for (i = 0; i < STATES; i++) {
        for (k = 0; k < STATES; k++) {
            if (!(FABS(s->F[i][k]) > 0)) continue;
            if (i > 0 || k > 0) x[i] += s->F[i][k] * s->x[k];
            for (j = 0; j < STATES; j++) FP[i][j] += s->F[i][k] * s->P[k][j];
        }
    }
    for (i = 0; i < STATES; i++) {
        if (i > 0) s->x[i] = x[i];
        for (j = 0; j < STATES; j++) s->P[i][j] = 0;
    }
    for (j = 0; j < STATES; j++) {
        for (k = 0; k < STATES; k++) {
            if (!(FABS(s->F[j][k]) > 0)) continue;
            for (i = 0; i < STATES; i++) s->P[i][j] += FP[i][k] * s->F[j][k];
        }
    }
    for (i = 0; i < STATES; i++) s->P[i][i] += s->wander[i];
    climb(&s->x[0], &s->low, x[0] + B[0] * a);
    s->x[1] += B[1] * a;
    for (i = 0; i < 2; i++) {
        for (j = 0; j < 2; j++) s->P[i][j] += variance * B[i] * B[j];
    }
}

/* The gain before division, P h, and the innovation's variance, h' P h + r; the innovation is returned. */
static real innovate(const baroarma_height *s, const real h[STATES], real z, real r, real Ph[STATES],
                     real *variance)
{
    int i, j;
    *variance = r;
    for (i = 0; i < STATES; i++) {
        Ph[i] = 0;
        for (j = 0; j < STATES; j++) Ph[i] += s->P[i][j] * h[j];
        z -= h[i] * s->x[i];
        *variance += h[i] * Ph[i];
    }
    return z;
}

/* x = x + k y,  P = (I - k h') P (I - k h')' + r k k'  with  k = P h / variance. */
static void absorb(baroarma_height *s, const real h[STATES], real y, real r, const real Ph[STATES], real variance)
{
    real gain[STATES], left[STATES][STATES], LP[STATES][STATES];
    int i, j, k;
    for (i = 0; i < STATES; i++) {
        gain[i] = Ph[i] / variance;
        if (i > 0) s->x[i] += gain[i] * y;
        for (j = 0; j < STATES; j++) left[i][j] = (real)(i == j) - gain[i] * h[j];
    }
    climb(&s->x[0], &s->low, gain[0] * y);
    for (i = 0; i < STATES; i++) {
        for (j = 0; j < STATES; j++) {
            LP[i][j] = 0;
            for (k = 0; k < STATES; k++) LP[i][j] += left[i][k] * s->P[k][j];
        }
    }
    for (i = 0; i < STATES; i++) {
        for (j = 0; j < STATES; j++) {
            s->P[i][j] = r * gain[i] * gain[j];
            for (k = 0; k < STATES; k++) s->P[i][j] += LP[i][k] * left[j][k];
        }
    }
}

/* From the sample before to this one; the height may have jumped on the way. */
static void advance(baroarma_height *s, real dt, real a, real acceleration_sd)
{
    const real sd = isnan(acceleration_sd) ? s->acceleration_sd : acceleration_sd;
    /* what changes by more than noise from sample to sample may do anything between them */
    const real beyond = s->drive.change - 5 * sd, missed = beyond > 0 ? BAROARMA_UNRESOLVED * beyond : 0;
    if (FABS(dt - s->dt) > 0) fill_model(s, dt);
    height_predict(s, a, square(sd) + square(missed));
    s->P[0][0] += square(s->jump);
    s->P[1][1] += square(s->jump);
    s->jump = 0;
    if (s->outliers > 0) s->doubted += dt;
}

/* altitude, m: NaN without a new sample; its acceleration's sd, m/s^2: NaN for the filter's own. */
static void height_step(baroarma_height *s, real dt, real altitude, real acceleration, real acceleration_sd)
{
    static const real VELOCITY[STATES] = {0, 1};
    const real a = drive_step(&s->drive, acceleration);
    real Ph[STATES], y, variance;
    if (s->started) advance(s, dt, a, acceleration_sd);
    s->started = 1;
    if (at_rest(&s->drive)) {
        y = innovate(s, VELOCITY, 0, square(BAROARMA_REST_SD), Ph, &variance);
        absorb(s, VELOCITY, y, square(BAROARMA_REST_SD), Ph, variance);
    }
    if (isnan(altitude)) return;
    y = innovate(s, BAROARMA_MEASUREMENT, altitude, BAROARMA_R, Ph, &variance);
    if (believes(s, y, variance)) absorb(s, BAROARMA_MEASUREMENT, y, BAROARMA_R, Ph, variance);
}

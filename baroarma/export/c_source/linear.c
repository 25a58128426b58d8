/* ---- the Kalman height filter's steps --------------------------------------------------------------------- */

#define STATES BAROARMA_STATES

static void height_start(baroarma_height *s, const baroarma_rest *rest)
{
    int i, j;
    for (i = 0; i < STATES; i++) {
        s->x[i] = 0;
        for (j = 0; j < STATES; j++) s->P[i][j] = 0;
        s->P[i][i] = BAROARMA_INITIAL_VARIANCE[i];
    }
    s->low = 0;
    s->started = 0;
    drive_start(&s->drive);
    fill_model(s, 0);
    start_model(s, rest);
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
            if (i > 0 || k > 0) x[i] += s->F[i][k] * s->x[k]; /* of the height, what it climbs */
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

/* One scalar measurement z = h' x + noise of variance r: P = (I - k h') P (I - k h')' + r k k'. */
static void height_update(baroarma_height *s, const real h[STATES], real z, real r)
{
    real gain[STATES], left[STATES][STATES], LP[STATES][STATES], variance = r;
    int i, j, k;
    for (i = 0; i < STATES; i++) {
        gain[i] = 0;
        for (j = 0; j < STATES; j++) gain[i] += s->P[i][j] * h[j];
        z -= h[i] * s->x[i];
        variance += h[i] * gain[i];
    }
    for (i = 0; i < STATES; i++) {
        gain[i] /= variance;
        for (j = 0; j < STATES; j++) left[i][j] = (real)(i == j) - gain[i] * h[j];
    }
    climb(&s->x[0], &s->low, gain[0] * z);
    for (i = 1; i < STATES; i++) s->x[i] += gain[i] * z;
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

/* The variance of what drives the step; what changes by more than noise from one acceleration sample to the
 * next may do anything between them. */
static real driving_variance(const baroarma_height *s, real acceleration_sd)
{
    const real sd = isnan(acceleration_sd) ? s->acceleration_sd : acceleration_sd;
    const real beyond = s->drive.change - 5 * sd;
    return square(sd) + (beyond > 0 ? square(BAROARMA_UNRESOLVED * beyond) : 0);
}

/* altitude, m: NaN without a new sample; its acceleration's sd, m/s^2: NaN for the filter's own. */
static void height_step(baroarma_height *s, real dt, real altitude, real acceleration, real acceleration_sd)
{
    static const real VELOCITY[STATES] = {0, 1};
    const real a = drive_step(&s->drive, acceleration);
    if (s->started) {
        if (FABS(dt - s->dt) > 0) fill_model(s, dt);
        height_predict(s, a, driving_variance(s, acceleration_sd));
    }
    s->started = 1;
    if (at_rest(&s->drive)) height_update(s, VELOCITY, 0, square(BAROARMA_REST_SD));
    if (!isnan(altitude)) height_update(s, BAROARMA_MEASUREMENT, altitude, BAROARMA_R);
}

/* ---- the steps of a Kalman height filter ------------------------------------------------------------------ */

#define STATES BAROARMA_STATES

static void filter_start(baroarma_filter *s)
{
    int i, j;
    for (i = 0; i < STATES; i++) {
        s->x[i] = 0;
        for (j = 0; j < STATES; j++) s->P[i][j] = 0;
        s->P[i][i] = BAROARMA_INITIAL_VARIANCE[i];
    }
    s->low = 0;
}

static void model_start(baroarma_model *m)
{
    int i, j;
    m->dt = NO_SAMPLE;
    for (i = 0; i < STATES; i++) {
        for (j = 0; j < STATES; j++) m->F[i][j] = 0;
        m->B[i] = m->wander[i] = 0;
    }
}

/* How far the height wanders in an interval too long for an acceleration to be held. */
static real unseen_variance(real dt)
{
    return dt > BAROARMA_STALE ? square(BAROARMA_UNSEEN_WALK) * dt * dt * dt / 12 : 0;
}

/* x = F x + B a,  P = F P F' + wander + variance B B'; zeros of F are skipped.  In an interval that is too long
 * nothing was felt. */
static void filter_predict(baroarma_filter *s, const baroarma_model *m, real a, real variance)
{
    real FP[STATES][STATES] = {{0}}, x[STATES];
    int i, j, k;
    if (m->dt > BAROARMA_STALE) a = 0;
    for (i = 0; i < STATES; i++) {
        x[i] = m->B[i] * a;
        for (k = 0; k < STATES; k++) {
            if (!(FABS(m->F[i][k]) > 0)) continue;
            if (i > 0 || k > 0) x[i] += m->F[i][k] * s->x[k]; /* of the height, what it climbs */
            for (j = 0; j < STATES; j++) FP[i][j] += m->F[i][k] * s->P[k][j];
        }
    }
    climb(&s->x[0], &s->low, x[0]);
    for (i = 1; i < STATES; i++) s->x[i] = x[i];
    for (i = 0; i < STATES; i++) {
        for (j = i; j < STATES; j++) {
            real sum = variance * m->B[i] * m->B[j];
            for (k = 0; k < STATES; k++) {
                if (FABS(m->F[j][k]) > 0) sum += FP[i][k] * m->F[j][k];
            }
            s->P[i][j] = sum;
            s->P[j][i] = sum;
        }
        s->P[i][i] += m->wander[i];
    }
}

/* The innovation of z = h' x + noise of variance r, and its variance; `gain` becomes P h. */
static real filter_innovate(const baroarma_filter *s, const real h[STATES], real z, real r, real gain[STATES],
                            real *variance)
{
    int i, j;
    *variance = r;
    for (i = 0; i < STATES; i++) {
        gain[i] = 0;
        for (j = 0; j < STATES; j++) gain[i] += s->P[j][i] * h[j];
        z -= h[i] * s->x[i];
        *variance += h[i] * gain[i];
    }
    return z;
}

/* The update with the innovation y, in Joseph's form: P = (I - k h') P (I - k h')' + r k k'. */
static void filter_absorb(baroarma_filter *s, const real h[STATES], real gain[STATES], real y, real variance,
                          real r)
{
    real row[STATES];
    int i, j;
    for (i = 0; i < STATES; i++) {
        row[i] = gain[i];
        gain[i] /= variance;
        if (i > 0) s->x[i] += gain[i] * y;
    }
    climb(&s->x[0], &s->low, gain[0] * y);
    for (i = 0; i < STATES; i++) {
        for (j = 0; j < STATES; j++) s->P[i][j] -= gain[i] * row[j];
    }
    for (i = 0; i < STATES; i++) {
        row[i] = -r * gain[i];
        for (j = 0; j < STATES; j++) row[i] += s->P[i][j] * h[j];
    }
    for (i = 0; i < STATES; i++) {
        for (j = i; j < STATES; j++) {
            s->P[i][j] -= row[i] * gain[j];
            s->P[j][i] = s->P[i][j];
        }
    }
}

/* Take z = h' x + noise of variance r; what is known exactly tells nothing new. */
static void filter_update(baroarma_filter *s, const real h[STATES], real z, real r)
{
    real gain[STATES], variance;
    const real y = filter_innovate(s, h, z, r, gain, &variance);
    if (variance > 0) filter_absorb(s, h, gain, y, variance, r);
}

/* Take one state for known. */
static void filter_pin(baroarma_filter *s, int state, real value, real r)
{
    real h[STATES] = {0};
    h[state] = 1;
    filter_update(s, h, value, r);
}

/* The variance of what drives the step; what changes by more than noise from one acceleration sample to the
 * next may do anything between them. */
static real driving_variance(const baroarma_drive *drive, real acceleration_sd)
{
    const real beyond = drive->change - 5 * acceleration_sd;
    return square(acceleration_sd) + (beyond > 0 ? square(BAROARMA_UNRESOLVED * beyond) : 0);
}

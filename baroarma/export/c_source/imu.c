/* ---- what both attitude filters do with their samples --------------------------------------------------- */

/* Whether a specific force is no free fall's. */
static int has_vertical(const real force[3])
{
    return dot(force, force) > square(BAROARMA_LEAST_FORCE);
}

/* Grow older by dt; whether the last gyro sample is too old to be held, and then forget it. */
static int forget_rate(baroarma_rate *held, real dt)
{
    int i;
    held->age += dt;
    if (held->age <= BAROARMA_LONGEST_HOLD) return 0;
    for (i = 0; i < 3; i++) held->rate[i] = 0;
    return 1;
}

/* Take gyro - bias for the next interval; without a sample, hold.  A lost tilt stays lost. */
static void take_rate(baroarma_rate *held, const real gyro[3])
{
    int i;
    if (!is_rate(gyro)) return;
    for (i = 0; i < 3; i++) held->rate[i] = gyro[i] - held->bias[i];
    if (held->age <= BAROARMA_LONGEST_HOLD) held->age = 0;
}

static void hold_nothing(baroarma_rate *held, const real bias[3])
{
    int i;
    for (i = 0; i < 3; i++) {
        held->rate[i] = 0;
        held->bias[i] = bias[i];
    }
    held->age = 0;
}

/* ---- the attitude filters' Kalman steps ----------------------------------------------------------------- */

#define N BAROARMA_ATTITUDE_STATES

/* x = F x and P = F P F' + Q; zeros of F are skipped. */
static void attitude_predict(real x[N], real P[N][N], real F[N][N], real Q[N][N])
{
    real FP[N][N] = {{0}}, before[N];
    int i, j, k;
    for (i = 0; i < N; i++) {
        for (k = 0; k < N; k++) {
            if (!(FABS(F[i][k]) > 0)) continue;
            for (j = 0; j < N; j++) FP[i][j] += F[i][k] * P[k][j];
        }
    }
    for (i = 0; i < N; i++) {
        for (j = 0; j < N; j++) P[i][j] = Q[i][j];
    }
    for (j = 0; j < N; j++) {
        for (k = 0; k < N; k++) {
            if (!(FABS(F[j][k]) > 0)) continue;
            for (i = 0; i < N; i++) P[i][j] += FP[i][k] * F[j][k];
        }
    }
    for (i = 0; i < N; i++) before[i] = x[i];
    for (i = 0; i < N; i++) {
        x[i] = 0;
        for (k = 0; k < N; k++) x[i] += F[i][k] * before[k];
    }
}

/* One scalar measurement with innovation y, row h of H and variance r, in Joseph's form:
 * P = (I - k h') P (I - k h')' + r k k'. */
static void attitude_update(real x[N], real P[N][N], const real h[N], real y, real r)
{
    real gain[N], row[N], s = r;
    int i, j;
    for (i = 0; i < N; i++) {
        row[i] = 0;
        for (j = 0; j < N; j++) row[i] += P[i][j] * h[j];
        s += h[i] * row[i];
    }
    for (i = 0; i < N; i++) {
        gain[i] = row[i] / s;
        x[i] += gain[i] * y;
    }
    for (i = 0; i < N; i++) {
        for (j = 0; j < N; j++) P[i][j] -= gain[i] * row[j];
    }
    for (i = 0; i < N; i++) {
        row[i] = -r * gain[i];
        for (j = 0; j < N; j++) row[i] += P[i][j] * h[j];
    }
    for (i = 0; i < N; i++) {
        for (j = 0; j < N; j++) P[i][j] -= row[i] * gain[j];
    }
}

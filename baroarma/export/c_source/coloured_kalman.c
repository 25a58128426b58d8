/* ---- height: Kalman filter with the altimeter's coloured noise in the state -------------------------------
 *
 *     state [h, v, accelerometer bias, barometer offset, Gauss-Markov noise], the last two if there are such,
 *     h = h- + dt v- + dt^2/2 (a - bias),   v = v- + dt (a - bias),   z = h + offset + Gauss-Markov + white
 *
 * Bias and offset walk at random; Gauss-Markov noise decays with its correlation time. */

static void fill_model(baroarma_height *s, real dt)
{
    int i, j;
    s->dt = dt;
    for (i = 0; i < BAROARMA_STATES; i++) {
        const real phi = decay(BAROARMA_DECAY_RATE[i], dt);
        for (j = 0; j < BAROARMA_STATES; j++) s->F[i][j] = 0;
        s->F[i][i] = phi;
        s->wander[i] = BAROARMA_WALK_VARIANCE[i] * dt + BAROARMA_STATIONARY_VARIANCE[i] * (1 - phi * phi);
    }
    s->F[0][1] = dt;
    s->F[0][2] = -dt * dt / 2;
    s->F[1][2] = -dt;
}

/* Acceleration's noise and bias are what the rest at the start tells, if it tells them. */
static void start_model(baroarma_height *s, const baroarma_rest *rest)
{
    s->acceleration_sd = BAROARMA_ACCELERATION_SD;
    if (isnan(rest->accel_sd)) return;
    if (BAROARMA_SD_FROM_REST) s->acceleration_sd = rest->accel_sd;
    s->P[2][2] = square(rest->gravity_sd) + square(BAROARMA_LEFT_BIAS_SD);
}

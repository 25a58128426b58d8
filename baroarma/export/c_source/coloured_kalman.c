/* ---- height: Kalman filter with the altimeter's coloured noise in the state -------------------------------
 *
 *     state [h, v, accelerometer bias, low-passed height, barometer offset, Gauss-Markov noise], the last three
 *     if there are such,
 *     h = h- + dt v- + dt^2/2 (a - bias),   v = v- + dt (a - bias),   z = h + offset + Gauss-Markov + white
 *
 * Bias and offset walk at random; Gauss-Markov noise decays with its correlation time.  A barometer of time
 * constant tau shows l instead of h, with l' = (h - l)/tau. */

/* The low-passed height follows height, velocity and acceleration exactly: l' = (h + v t + a t^2/2 - l)/tau. */
static void fill_lag(baroarma_model *m, real dt)
{
    const int l = BAROARMA_LOW_PASSED;
    const real tau = BAROARMA_LAG, risen = -EXPM1(-dt / tau);
    m->F[l][0] = risen;
    m->F[l][1] = dt - tau * risen;
    m->F[l][l] = EXP(-dt / tau);
    m->B[l] = dt * dt / 2 - tau * dt + square(tau) * risen;
    m->F[l][2] = -m->B[l];
}

static void fill_model(baroarma_model *m, real dt)
{
    int i;
    m->dt = dt;
    for (i = 0; i < STATES; i++) {
        const real phi = decay(BAROARMA_DECAY_RATE[i], dt);
        m->F[i][i] = phi;
        m->wander[i] = BAROARMA_WALK_VARIANCE[i] * dt + BAROARMA_STATIONARY_VARIANCE[i] * (1 - phi * phi);
    }
    m->wander[0] = unseen_variance(dt);
    m->B[0] = dt * dt / 2;
    m->B[1] = dt;
    m->F[0][1] = dt;
    m->F[0][2] = -m->B[0];
    m->F[1][2] = -dt;
    if (BAROARMA_LOW_PASSED) fill_lag(m, dt);
}

/* Acceleration's noise and bias are what the rest at the start tells, if it tells them. */
static void start_model(baroarma_height *s, const baroarma_rest *rest)
{
    baroarma_filter *f = &s->filters[0];
    filter_start(f);
    model_start(&s->model);
    s->acceleration_sd = BAROARMA_ACCELERATION_SD;
    s->bias_sd = BAROARMA_BIAS_SD;
    if (BAROARMA_LOW_PASSED) { /* starts as the height does */
        f->P[0][BAROARMA_LOW_PASSED] = BAROARMA_INITIAL_VARIANCE[0];
        f->P[BAROARMA_LOW_PASSED][0] = BAROARMA_INITIAL_VARIANCE[0];
    }
    if (isnan(rest->accel_sd)) return;
    if (BAROARMA_SD_FROM_REST) s->acceleration_sd = rest->accel_sd;
    if (BAROARMA_BIAS_FROM_REST) s->bias_sd = HYPOT(BAROARMA_BIAS_SD, rest->gravity - BAROARMA_STANDARD_GRAVITY);
    f->P[2][2] = square(BAROARMA_LEFT_BIAS_SD);
    if (!isnan(rest->gravity_sd)) f->P[2][2] += square(rest->gravity_sd);
}

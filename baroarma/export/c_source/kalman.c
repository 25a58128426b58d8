/* ---- height: Kalman filter of height and velocity ---------------------------------------------------------
 *
 *     h = h- + dt v- + dt^2/2 a,   v = v- + dt a,   z = h + white noise       [Tanigawa 2008; Lee16, Eq. 11]
 */

static void fill_model(baroarma_model *m, real dt)
{
    m->dt = dt;
    m->F[0][0] = m->F[1][1] = 1;
    m->F[0][1] = dt;
    m->wander[0] = unseen_variance(dt);
    m->B[0] = dt * dt / 2;
    m->B[1] = dt;
}

/* The noise is what the settings say, whatever the rest at the start looked like. */
static void height_start(baroarma_height *s, const baroarma_rest *rest)
{
    (void)rest;
    filter_start(&s->filter);
    model_start(&s->model);
    s->started = 0;
    drive_start(&s->drive);
}

/* altitude, m: NaN without a new sample; its acceleration's sd, m/s^2: NaN for the filter's own.  What the IMU
 * feels at rest has no effect here. */
static void height_step(baroarma_height *s, real dt, real altitude, real acceleration, real acceleration_sd,
                        const real up[3], int still)
{
    const real a = drive_step(&s->drive, acceleration);
    const real sd = isnan(acceleration_sd) ? BAROARMA_ACCELERATION_SD : acceleration_sd;
    const real step = dt < BAROARMA_LONGEST_GAP ? dt : BAROARMA_LONGEST_GAP;
    (void)up;
    (void)still;
    if (s->started) {
        if (!(FABS(step - s->model.dt) <= 0)) fill_model(&s->model, step);
        filter_predict(&s->filter, &s->model, a, driving_variance(&s->drive, sd));
    }
    s->started = 1;
    if (at_rest(&s->drive)) filter_pin(&s->filter, 1, 0, square(BAROARMA_REST_SD));
    if (!isnan(altitude)) filter_update(&s->filter, BAROARMA_MEASUREMENT, altitude, BAROARMA_R);
}

static void height_tell(const baroarma_height *s, baroarma_result *result)
{
    result->height = s->filter.x[0];
    result->velocity = s->filter.x[1];
    result->height_sd = root_of(s->filter.P[0][0]);
    result->velocity_sd = root_of(s->filter.P[1][1]);
}

/* ---- height: Kalman filter of height and velocity ---------------------------------------------------------
 *
 *     h = h- + dt v- + dt^2/2 a,   v = v- + dt a,   z = h + white noise       [Tanigawa 2008; Lee16, Eq. 11]
 */

static void fill_model(baroarma_height *s, real dt)
{
    s->dt = dt;
    s->F[0][0] = s->F[1][1] = 1;
    s->F[0][1] = dt;
    s->F[1][0] = 0;
    s->wander[0] = s->wander[1] = 0;
}

/* The noise is what the settings say, whatever the rest at the start looked like. */
static void start_model(baroarma_height *s, const baroarma_rest *rest)
{
    (void)rest;
    s->acceleration_sd = BAROARMA_ACCELERATION_SD;
}

/* ---- conditioning of the altitude: none ------------------------------------------------------------------- */

static void conditioning_start(baroarma_conditioning *s)
{
    s->nothing = 0;
}

static void conditioning_shift(baroarma_conditioning *s, real zero)
{
    (void)s;
    (void)zero;
}

static real conditioning_step(baroarma_conditioning *s, real altitude)
{
    (void)s;
    return altitude;
}

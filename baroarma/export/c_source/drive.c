/* ---- how acceleration samples drive the height filter ----------------------------------------------------- */

static void drive_start(baroarma_drive *s)
{
    s->last = s->change = 0;
    s->quiet = 0;
}

/* Take an acceleration (m/s^2; NaN: the last one is held); what drives the step that ends here, m/s^2. */
static real drive_step(baroarma_drive *s, real acceleration)
{
    const real now = isnan(acceleration) ? s->last : acceleration;
    const real used = BAROARMA_MIDPOINT ? (s->last + now) / 2 : s->last;
    if (FABS(now) < BAROARMA_ZUPT_THRESHOLD) {
        if (s->quiet <= BAROARMA_ZUPT_STEPS) s->quiet++;
    } else {
        s->quiet = 0;
    }
    s->change = FABS(now - s->last);
    s->last = now;
    return used;
}

/* At rest: quiet on the closed interval of n steps [Lee16, Eq. 14]; no steps: no such rule. */
static int at_rest(const baroarma_drive *s)
{
    return BAROARMA_ZUPT_STEPS > 0 && s->quiet > BAROARMA_ZUPT_STEPS;
}

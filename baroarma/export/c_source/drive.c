/* ---- how acceleration samples drive the height filter ----------------------------------------------------- */

static void drive_start(baroarma_drive *s)
{
    s->before = s->last = s->change = 0;
    s->quiet = 0;
}

/* Take an acceleration (m/s^2; NaN: the last one is held); what drives the step that ends here, m/s^2.
 * A sample that is wild between two that agree is taken out again when the second of them comes. */
static real drive_step(baroarma_drive *s, real acceleration)
{
    const real now = isnan(acceleration) ? s->last : acceleration, jump = FABS(s->last - s->before);
    real used;
    if (FABS(now) < BAROARMA_ZUPT_THRESHOLD) {
        if (s->quiet <= BAROARMA_ZUPT_STEPS) s->quiet++;
    } else {
        s->quiet = 0;
    }
    s->change = FABS(now - s->last);
    if (jump > BAROARMA_WILD && FABS(now - s->before) < BAROARMA_BACK * jump) {
        s->last = BAROARMA_MIDPOINT ? 2 * s->before - s->last : s->before;
    } else {
        s->before = s->last;
    }
    used = BAROARMA_MIDPOINT ? (s->last + now) / 2 : s->last;
    s->last = now;
    return used;
}

/* At rest: quiet on the closed interval of n steps [Lee16, Eq. 14]; no steps: no such rule. */
static int at_rest(const baroarma_drive *s)
{
    return BAROARMA_ZUPT_STEPS > 0 && s->quiet > BAROARMA_ZUPT_STEPS;
}

/* ---- conditioning of the altitude: moving average over new samples [SG14, Method A] ----------------------- */

static void conditioning_start(baroarma_conditioning *s)
{
    s->count = 0;
}

/* What the samples so far would have left behind, had they been lower by `zero`. */
static void conditioning_shift(baroarma_conditioning *s, real zero)
{
    int i;
    for (i = 0; i < s->count; i++) s->recent[i] -= zero;
}

/* Take a new altitude, m. */
static real conditioning_step(baroarma_conditioning *s, real altitude)
{
    real sum = 0;
    int i;
    if (s->count == BAROARMA_AVERAGE) {
        for (i = 1; i < BAROARMA_AVERAGE; i++) s->recent[i - 1] = s->recent[i];
        s->count--;
    }
    s->recent[s->count++] = altitude;
    for (i = 0; i < s->count; i++) sum += s->recent[i];
    return sum / (real)s->count;
}

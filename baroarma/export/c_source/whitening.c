/* ---- conditioning of the altitude: moving average and whitening filter [SG14, Method B] ------------------
 *
 *     y_k + a_1 y_{k-1} = b_0 x_k + b_1 x_{k-1},  begun in the steady state of the first sample
 *
 * A steady height change is reported BAROARMA_DC_GAIN times its size. */

/* The filter's delay after a constant input for a long time. */
static real steady(real altitude)
{
    return (BAROARMA_B1 - BAROARMA_A1 * BAROARMA_DC_GAIN) * altitude;
}

static void conditioning_start(baroarma_conditioning *s)
{
    s->count = 0;
    s->delay = 0;
}

/* What the samples so far would have left behind, had they been lower by `zero`: the filters are linear. */
static void conditioning_shift(baroarma_conditioning *s, real zero)
{
    int i;
    for (i = 0; i < s->count; i++) s->recent[i] -= zero;
    if (s->count > 0) s->delay -= steady(zero);
}

/* Take a new altitude, m. */
static real conditioning_step(baroarma_conditioning *s, real altitude)
{
    real mean = 0, whitened;
    int i;
    if (s->count == 0) s->delay = steady(altitude);
    if (s->count == BAROARMA_AVERAGE) {
        for (i = 1; i < BAROARMA_AVERAGE; i++) s->recent[i - 1] = s->recent[i];
        s->count--;
    }
    s->recent[s->count++] = altitude;
    for (i = 0; i < s->count; i++) mean += s->recent[i];
    mean /= (real)s->count;
    whitened = BAROARMA_B0 * mean + s->delay;
    s->delay = BAROARMA_B1 * mean - BAROARMA_A1 * whitened;
    return whitened;
}

/* ---- what the rest before the first row says about the barometer's offset ---------------------------------
 *
 * How noisy the accelerometer is, and so how much an altitude tells, is known when the second is over: until
 * then its altitudes are kept. */

static void early_start(baroarma_early *s)
{
    const baroarma_early_rows nothing = {0, 0, NO_SAMPLE};
    s->count = s->altitudes = 0;
    s->entries[0] = nothing;
}

/* Take a row, dt s after the one before (the first: 0).  Altitudes beyond the room for them don't count. */
static void early_take(baroarma_early *s, real dt, real altitude)
{
    const baroarma_early_rows nothing = {0, 0, NO_SAMPLE};
    baroarma_early_rows *now = &s->entries[s->count];
    const int left = BAROARMA_EARLY_ALTITUDES - s->altitudes, room = BAROARMA_EARLY_ROWS - s->count;
    now->rows++;
    now->span += dt;
    now->altitude = altitude;
    if (s->count == BAROARMA_EARLY_ROWS || (isnan(altitude) && room <= left)) return;
    if (!isnan(altitude)) s->altitudes++;
    s->entries[++s->count] = nothing;
}

/* Repeat the second, at rest, up to the row dt s after its last one: the first of the estimates. */
static void height_look_back(baroarma_height *s, baroarma_early *early, real dt)
{
    int i, k;
    if (!BAROARMA_CONFIRM_REST) return;
    early_take(early, dt, NO_SAMPLE);
    for (i = 0; i <= early->count; i++) {
        const baroarma_early_rows *e = &early->entries[i];
        const int steps = s->started ? e->rows : e->rows - 1;
        const real each = steps > 0 ? e->span / (real)steps : 0;
        for (k = 1; k <= e->rows; k++) {
            const real altitude = k < e->rows ? NO_SAMPLE : e->altitude;
            height_step(s, each, altitude, NO_SAMPLE, NO_SAMPLE, s->anchor, 1);
        }
    }
    s->started = 0;
}

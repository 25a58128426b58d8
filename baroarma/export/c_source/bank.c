/* ---- a bank of filters that weighs 'at rest' against 'moving' ---------------------------------------------
 *
 * What feels nothing may rest or ride at a constant speed.  When the IMU falls still the filter forks:
 *
 *     RESTED        takes v = 0 at every row,
 *     FREE          never does,
 *     RECENT, +1    copies of RESTED that have taken no v = 0 for one to two times BAROARMA_MEMORY seconds.
 *
 * The log-odds of RESTED against FREE begin with what the free velocity says,
 *
 *     odds = log prior + log N(v; 0, P_vv + r) - log N(v; 0, P_vv + cruise^2),
 *
 * and every altitude adds the difference of the two log-likelihoods.  RESTED speaks while they are positive,
 * else FREE; once refuted, the rest is considered anew every BAROARMA_RECOVERY seconds, for a soft stop is not
 * felt.  A rest ends when the IMU says so, or when the velocity of the older RECENT does: a soft start.  The
 * velocity's sd is that of both possibilities.
 *
 * An altitude beyond the gate is not taken, nor are many that are off by less, but all one way.  If none was
 * taken for a while, something has really jumped: the barometer's offset if by a few metres, once and for all,
 * else the height. */

enum { RESTED = 0, FREE = 1, RECENT = 2, HEIGHT = 0, VELOCITY = 1, BIAS = 2 };

static real larger(real a, real b)
{
    return a > b ? a : b;
}

static real smaller(real a, real b)
{
    return a < b ? a : b;
}

static int active(const baroarma_height *s)
{
    return s->forked ? BAROARMA_FILTERS : 1;
}

/* The filter that speaks for the bank. */
static int speaker(const baroarma_height *s)
{
    return s->forked && (s->odds < 0 || s->refuted) ? FREE : RESTED;
}

static real within(real value, real most)
{
    return smaller(larger(value, -most), most);
}

static void copy_filter(baroarma_height *s, int source, int target)
{
    if (source == target) return;
    s->filters[target] = s->filters[source];
    s->doubts[target] = s->doubts[source];
}

static void height_start(baroarma_height *s, const baroarma_rest *rest)
{
    const baroarma_doubt none = {{0, 0}, 0, 0, 0, 0, 0};
    int i;
    start_model(s, rest);
    for (i = 0; i < BAROARMA_FILTERS; i++) {
        copy_filter(s, RESTED, i);
        s->doubts[i] = none;
    }
    s->forked = s->on_floor = s->started = 0;
    s->older = RECENT;
    s->odds = s->silence = s->away = 0;
    s->refuted = s->repeats = 0;
    s->altitude = 0;
    set_clock(&s->age, 0);
    set_clock(&s->since, 0);
    s->sway = square(BAROARMA_SWAY);
    for (i = 0; i < 3; i++) s->anchor[i] = rest->up[i];
    drive_start(&s->drive);
}

/* What the turn away from the last rest adds to the bias's variance, (m/s^2)^2: between verticals that enclose
 * an angle the bias differs with a variance of 2 (1 - cos angle) times its own. */
static real turned(baroarma_height *s, const real up[3], int still)
{
    const real away = 1 - dot(s->anchor, up), more = away - s->away;
    int i;
    if (!still && !(more > 0)) return 0;
    s->away = still ? 0 : away;
    for (i = 0; still && i < 3; i++) s->anchor[i] = up[i];
    return still ? 0 : 2 * more * square(s->bias_sd);
}

/* Predict; the bias has turned, and what has jumped is loose: a height that did may be moving, too. */
static void advance(baroarma_height *s, int i, real dt, real a, real variance, real turn_variance)
{
    baroarma_filter *f = &s->filters[i];
    baroarma_doubt *d = &s->doubts[i];
    if (s->started) filter_predict(f, &s->model, a, variance);
    f->P[BIAS][BIAS] += turn_variance;
    if (d->jump < 0) {
        f->P[BAROARMA_OFFSET][BAROARMA_OFFSET] += square(d->jump);
    } else {
        f->P[HEIGHT][HEIGHT] += square(d->jump);
        f->P[VELOCITY][VELOCITY] += square(d->jump / BAROARMA_JUMP_TIME);
    }
    d->jump = 0;
    if (d->count > 0) tick(&d->since, dt);
}

/* Begin to consider a rest, from the filter `source`; again, if that is the free one of a fork. */
static void consider_rest(baroarma_height *s, int source, real rest_variance)
{
    baroarma_filter *f = &s->filters[RESTED];
    real v, still, riding, odds;
    int i;
    copy_filter(s, source, RESTED);
    for (i = 1; i < BAROARMA_FILTERS; i++) copy_filter(s, RESTED, i);
    v = f->x[VELOCITY];
    still = larger(f->P[VELOCITY][VELOCITY] + rest_variance, BAROARMA_EXACT);
    riding = f->P[VELOCITY][VELOCITY] + square(BAROARMA_CRUISE_SD);
    odds = BAROARMA_PRIOR_ODDS + (LOG(riding / still) + v * v * (1 / riding - 1 / still)) / 2;
    if (source == FREE && odds < BAROARMA_SURE) odds = smaller(odds, -BAROARMA_SURE);
    /* a velocity that no rest explains is an error of its own, and tells nothing about height and bias */
    f->P[VELOCITY][VELOCITY] += larger(v * v - 4 * still, 0);
    s->forked = 1;
    s->older = RECENT;
    s->on_floor = 0;
    s->odds = within(odds, BAROARMA_LONGEST_ODDS);
    s->refuted = odds <= -BAROARMA_SURE;
    set_clock(&s->age, 0);
    set_clock(&s->since, 0);
}

/* Whether what surely rested has come to a velocity, since shortly before, that is none of a rest. */
static int starts(const baroarma_height *s)
{
    const baroarma_filter *f = &s->filters[s->older];
    const real variance = f->P[VELOCITY][VELOCITY] + larger(s->sway, square(BAROARMA_SWAY));
    return s->odds > BAROARMA_SURE && square(f->x[VELOCITY]) > square(BAROARMA_ONSET) * variance;
}

/* Learn how fast what rests still moves: what the older recent filter sees beyond its own variance. */
static void watch_sway(baroarma_height *s, real dt)
{
    const baroarma_filter *f = &s->filters[s->older];
    const real own = f->P[VELOCITY][VELOCITY];
    real excess;
    if (!(s->age.time > 0 && speaker(s) == RESTED)) return;
    excess = smaller(square(f->x[VELOCITY]), 4 * (own + s->sway)) - own; /* a start is no sway */
    s->sway = larger(s->sway + smaller(dt / BAROARMA_SWAY_TIME, 1) * (excess - s->sway), 0);
}

/* Let the older of the recent filters begin anew from the rested one. */
static void renew(baroarma_height *s, real dt)
{
    if (!(s->age.time > 0)) {
        copy_filter(s, RESTED, RECENT);
        copy_filter(s, RESTED, RECENT + 1);
    }
    tick(&s->age, dt);
    tick(&s->since, dt);
    if (s->since.time < BAROARMA_MEMORY - BAROARMA_ROUNDING) return;
    copy_filter(s, RESTED, s->older);
    s->older = 2 * RECENT + 1 - s->older;
    set_clock(&s->since, 0);
}

/* How probable it is that the filter that doesn't speak is right. */
static real chance(const baroarma_height *s)
{
    const real odds = s->odds - (s->refuted ? BAROARMA_SURE : 0);
    return 1 / (1 + EXP(FABS(odds)));
}

/* The rest is over: go on with one filter, whose velocity may have been the other one's. */
static void join(baroarma_height *s)
{
    const int rests = speaker(s) == RESTED, one = rests ? s->older : FREE, other = rests ? FREE : s->older;
    const real off = s->filters[other].x[VELOCITY] - s->filters[one].x[VELOCITY];
    copy_filter(s, one, RESTED);
    s->filters[RESTED].P[VELOCITY][VELOCITY] += chance(s) * square(off);
    s->forked = 0;
}

/* Whether a rest begins or ends here; `still` is what the IMU says, not yet what is believed. */
static void weigh_rest(baroarma_height *s, real dt, int still, real rest_variance)
{
    if (s->forked && (!still || starts(s))) join(s);
    if (s->forked && s->odds < -BAROARMA_SURE && s->age.time >= BAROARMA_RECOVERY - BAROARMA_ROUNDING) {
        consider_rest(s, FREE, rest_variance);
    }
    if (still && !s->forked) consider_rest(s, RESTED, rest_variance);
    if (!s->forked) return;
    filter_pin(&s->filters[RESTED], VELOCITY, 0, rest_variance + s->sway);
    watch_sway(s, dt);
    renew(s, dt);
}

/* Whether a filter takes an altitude that is off by y m; its doubts are kept. */
static int is_taken(baroarma_doubt *d, real y, real sd, real share)
{
    const real gate = BAROARMA_GATE;
    d->sum = share * d->sum + SQRT(1 - share * share) * within(y / sd, gate);
    if (FABS(y) <= gate * sd && FABS(d->sum) <= gate) {
        d->count = 0;
        set_clock(&d->since, 0);
        return 1;
    }
    if (d->count == 0) d->first = d->late = y;
    if (d->count < 30000) d->count++;
    d->late += (1 - share) * (y - d->late);
    if (d->since.time <= BAROARMA_RECOVERY / 2) d->first += (y - d->first) / (real)d->count;
    if (d->count >= BAROARMA_PROOF && d->since.time >= BAROARMA_RECOVERY - BAROARMA_ROUNDING) {
        const int stays = FABS(d->late - d->first) < (real)0.3 * FABS(d->late) + sd / 4;
        d->jump = stays && FABS(y) <= BAROARMA_PRESSURE_STEP ? -FABS(y) : FABS(y);
        d->count = 0;
        set_clock(&d->since, 0);
        d->sum = 0;
    }
    return 0;
}

/* Whether an altitude, m, has come again too often for news: the barometer hangs. */
static int hangs(baroarma_height *s, real altitude)
{
    const int again = altitude <= s->altitude && altitude >= s->altitude;
    if (again && s->repeats < BAROARMA_MOST_REPEATS) s->repeats++;
    if (!again) s->repeats = 0;
    s->altitude = altitude;
    return s->repeats >= BAROARMA_MOST_REPEATS;
}

/* Let every filter judge an altitude, m, and the odds hear how well two of them foretold it. */
static void take_altitude(baroarma_height *s, real altitude)
{
    const real share = EXP(-s->silence / BAROARMA_TOGETHER);
    const int n = active(s);
    real news = 0;
    int i, believed = 0;
    s->silence = 0;
    for (i = 0; i < n; i++) {
        real gain[STATES], variance, sd;
        const real *h = BAROARMA_MEASUREMENT, sign = i == RESTED ? 1 : -1;
        const real y = filter_innovate(&s->filters[i], h, altitude, BAROARMA_R, gain, &variance);
        int taken;
        if (!(variance > 0)) continue; /* a second sample at the same instant */
        sd = SQRT(variance);
        taken = is_taken(&s->doubts[i], y, sd, share);
        if (taken) filter_absorb(&s->filters[i], h, gain, y, variance, BAROARMA_R);
        if (n == 1 || i > FREE) continue;
        news -= sign * (smaller(square(y / sd), square(BAROARMA_GATE)) / 2 + LOG(sd));
        believed = believed || taken;
        if (FABS(s->doubts[i].jump) > 0) s->odds -= sign * BAROARMA_JUMP_ODDS;
    }
    if (n == 1) return;
    if (believed) s->odds += within(news, BAROARMA_MOST_NEWS);
    s->odds = within(s->odds, BAROARMA_LONGEST_ODDS);
    if (FABS(s->odds) > BAROARMA_SURE) s->refuted = s->odds < 0;
}

/* Take the known floor that the rested filter stands on, once a rest, if it is sure. */
static void recognise_floor(baroarma_height *s)
{
    baroarma_filter *f = &s->filters[RESTED];
    const real variance = f->P[HEIGHT][HEIGHT] + BAROARMA_FLOOR_VARIANCE;
    real best = INFINITY, second = INFINITY;
    int i, found = 0;
    if (s->on_floor || s->odds < BAROARMA_SURE || s->age.time < BAROARMA_MEMORY - BAROARMA_ROUNDING) return;
    for (i = 0; i < BAROARMA_FLOORS; i++) {
        const real distance = square(f->x[HEIGHT] - BAROARMA_FLOOR[i]) / variance;
        if (distance < best) {
            second = best;
            best = distance;
            found = i;
        } else if (distance < second) {
            second = distance;
        }
    }
    if (best > 9 || second - best < 2 * BAROARMA_SURE) return;
    s->on_floor = 1;
    filter_pin(f, HEIGHT, BAROARMA_FLOOR[found], BAROARMA_FLOOR_VARIANCE);
}

/* altitude, m: NaN without a new sample; its acceleration's sd, m/s^2: NaN for the filter's own; `up`: the
 * vertical in body axes; still: whether the IMU feels nothing. */
static void height_step(baroarma_height *s, real dt, real altitude, real acceleration, real acceleration_sd,
                        const real up[3], int still)
{
    const real a = drive_step(&s->drive, acceleration);
    const real sd = isnan(acceleration_sd) ? s->acceleration_sd : acceleration_sd;
    const real variance = driving_variance(&s->drive, sd);
    const real rest_variance = larger(square(BAROARMA_REST_TIME) * variance, square(BAROARMA_REST_SD));
    const int quiet = BAROARMA_CONFIRM_REST && (still || at_rest(&s->drive));
    const real turn_variance = turned(s, up, quiet), step = dt < BAROARMA_LONGEST_GAP ? dt : BAROARMA_LONGEST_GAP;
    const real time = s->started ? step : 0;
    int i, n = active(s);
    if (s->started && !(FABS(time - s->model.dt) <= 0)) fill_model(&s->model, time);
    for (i = 0; i < n; i++) advance(s, i, time, a, variance, turn_variance);
    s->started = 1;
    s->silence += time;
    weigh_rest(s, time, quiet, rest_variance);
    n = active(s);
    for (i = 0; BAROARMA_LEVEL_PRIOR > 0 && time > 0 && i < n; i++) {
        filter_pin(&s->filters[i], HEIGHT, 0, BAROARMA_LEVEL_PRIOR / time);
    }
    if (!isnan(altitude) && !hangs(s, altitude)) take_altitude(s, altitude);
    if (s->forked && BAROARMA_FLOORS) recognise_floor(s);
}

/* The rms error of the speaker's velocity: it may be right, or the other one.  Of a rest's the older recent
 * filter's variance is meant: a start may have gone unnoticed for so long. */
static real sd_of_both(const baroarma_height *s)
{
    const int one = speaker(s), own = one == RESTED ? s->older : one;
    const baroarma_filter *other = &s->filters[one == RESTED ? FREE : RESTED];
    const real p = chance(s), off = other->x[VELOCITY] - s->filters[one].x[VELOCITY];
    return root_of((1 - p) * s->filters[own].P[VELOCITY][VELOCITY] + p * (other->P[VELOCITY][VELOCITY] + square(off)));
}

static void height_tell(const baroarma_height *s, baroarma_result *result)
{
    const baroarma_filter *f = &s->filters[speaker(s)];
    result->height = f->x[HEIGHT];
    result->velocity = f->x[VELOCITY];
    result->height_sd = root_of(f->P[HEIGHT][HEIGHT]);
    result->velocity_sd = s->forked ? sd_of_both(s) : root_of(f->P[VELOCITY][VELOCITY]);
}

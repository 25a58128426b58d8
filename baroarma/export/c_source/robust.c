/* ---- attitude: the tilt that keeps the velocity near zero --------------------------------------------------
 *
 * A strapdown computer turns the attitude by the trapezoid of two rates, less bias and scale, and integrates
 * the horizontal specific force.  Every T seconds a Kalman filter of the errors x = (tilt, velocity, gyro bias,
 * gyro scale) hears that the mean velocity of the interval was 0:
 *
 *     tilt' = -C_h (db + diag(w) ds),   v_x' = f_z tilt_y,   v_y' = -f_z tilt_x,      F: start to end,
 *     0 = mean(v) + H x + n,   var(n) = 2 sd^2 tau / T,                               H: start to mean.
 *
 * What it finds is folded into the estimates, and x is 0 again. */

#define ERRORS 10

static void fill_rotation(real C[3][3], const real q[4])
{
    const real x = q[0], y = q[1], z = q[2], w = q[3];
    C[0][0] = 1 - 2 * (y * y + z * z);
    C[0][1] = 2 * (x * y - z * w);
    C[0][2] = 2 * (x * z + y * w);
    C[1][0] = 2 * (x * y + z * w);
    C[1][1] = 1 - 2 * (x * x + z * z);
    C[1][2] = 2 * (y * z - x * w);
    C[2][0] = 2 * (x * z - y * w);
    C[2][1] = 2 * (y * z + x * w);
    C[2][2] = 1 - 2 * (x * x + y * y);
}

/* World from body axes, and back. */
static void to_world(real world[3], real C[3][3], const real body[3])
{
    int i;
    for (i = 0; i < 3; i++) world[i] = dot(C[i], body);
}

static void to_body(real body[3], real C[3][3], const real world[3])
{
    int i;
    for (i = 0; i < 3; i++) body[i] = C[0][i] * world[0] + C[1][i] * world[1] + C[2][i] * world[2];
}

/* q = q exp(angle / 2), a turn about body axes by so many rad. */
static void turn(real q[4], const real angle[3])
{
    const real half = SQRT(dot(angle, angle)) / 2, s = half > 0 ? SIN(half) / half / 2 : (real)0.5;
    const real x = s * angle[0], y = s * angle[1], z = s * angle[2], w = COS(half);
    const real a = q[0], b = q[1], c = q[2], d = q[3];
    q[0] = w * a + x * d + z * b - y * c;
    q[1] = w * b + y * d + x * c - z * a;
    q[2] = w * c + z * d + y * a - x * b;
    q[3] = w * d - x * a - y * b - z * c;
}

/* Begin a new interval. */
static void begin(baroarma_attitude *s)
{
    int i, j;
    for (i = 0; i < 6; i++) {
        for (j = 0; j < 6; j++) s->flow[i][j] = 0;
    }
    s->push = s->double_push = s->tilt_variance = s->velocity_variance = 0;
    for (i = 0; i < 2; i++) {
        s->way[i] = 0;
        s->start[i] = s->estimate[i];
    }
    set_clock(&s->age, 0);
}

/* The setting, else what the alignment says, else the usual; squared. */
static real noise_variance(real setting, real aligned, real usual)
{
    return square(setting > 0 ? setting : aligned > 0 ? aligned : usual);
}

static void doubt_nothing(baroarma_suspect *doubt)
{
    doubt->patience = BAROARMA_PATIENCE;
    doubt->open = 0;
}

static void attitude_start(baroarma_attitude *s, const baroarma_rest *rest)
{
    const real told = isnan(rest->gyro_bias_sd) ? 0 : rest->gyro_bias_sd;
    const real bias_sd = BAROARMA_BIAS_FROM_ALIGNMENT ? HYPOT(BAROARMA_INITIAL_SD[4], told) : BAROARMA_INITIAL_SD[4];
    int i, j;
    fill_level(s->q, rest->up);
    for (i = 0; i < 8; i++) s->estimate[i] = 0;
    for (i = 0; i < 3; i++) {
        s->estimate[2 + i] = s->rate[i] = rest->gyro_bias[i];
        s->force[i] = i == 2 ? rest->gravity : 0;
    }
    set_clock(&s->rate_age, 0);
    set_clock(&s->force_age, 0);
    doubt_nothing(&s->rate_doubt);
    doubt_nothing(&s->force_doubt);
    s->unsure = 0;
    s->noisy = rest->accel_sd > BAROARMA_LEAST_NOISE && rest->gyro_sd > BAROARMA_LEAST_NOISE;
    set_clock(&s->repeats, 0);
    for (i = 0; i < 3; i++) s->repeated[i] = NO_SAMPLE;
    begin(s);
    for (i = 0; i < ERRORS; i++) {
        for (j = 0; j < ERRORS; j++) s->P[i][j] = 0;
        s->P[i][i] = square(i >= 4 && i < 7 ? bias_sd : BAROARMA_INITIAL_SD[i]);
    }
    s->gravity = rest->gravity;
    s->gyro_noise = noise_variance(BAROARMA_GYRO_NOISE_SD, rest->gyro_sd, BAROARMA_USUAL_GYRO_NOISE_SD);
    s->accel_noise = noise_variance(BAROARMA_ACCEL_NOISE_SD, rest->accel_sd, BAROARMA_USUAL_ACCEL_NOISE_SD);
}

/* The error of a trapezoid over a whole gap: noise, and how much the curve may bend in it. */
static real gap_variance(real noise, real bend, real gap)
{
    return noise * square(gap) + square(bend * gap * gap * gap);
}

static real distance_squared(const real a[3], const real b[3])
{
    const real d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return dot(d, d);
}

/* Whether a sample whose jump has this square is to be seen again first. */
static int is_doubted(baroarma_suspect *doubt, const real v[3], real jump, real most)
{
    const int again = doubt->open && distance_squared(v, doubt->sample) < square(most);
    int i;
    if (jump > square(most) && doubt->patience >= 1 && !again) {
        doubt->patience -= 1;
        for (i = 0; i < 3; i++) doubt->sample[i] = v[i];
        doubt->open = 1;
        return 1;
    }
    if (jump <= square(most)) doubt->patience += BAROARMA_REGAINED;
    if (doubt->patience > BAROARMA_PATIENCE) doubt->patience = BAROARMA_PATIENCE;
    doubt->open = 0;
    return 0;
}

static int same(real a, real b)
{
    return a <= b && a >= b;
}

/* Whether a sensor with noise repeats itself for longer than it should, and not as one at rest.  From then on its
 * last samples count as being as old as they are. */
static int is_stuck(baroarma_attitude *s, real dt, const real accel[3], const real gyro[3])
{
    const real off = SQRT(dot(accel, accel)) - s->gravity, longest = BAROARMA_UNFELT;
    const real rate[3]
        = {gyro[0] - s->estimate[2], gyro[1] - s->estimate[3], gyro[2] - s->estimate[4]};
    const int moves = dot(rate, rate) > square(BAROARMA_MOVING_RATE) || FABS(off) > BAROARMA_MOVING_FORCE;
    int i, repeats = s->noisy;
    for (i = 0; i < 3; i++) {
        repeats = repeats && same(gyro[i], s->rate[i]) && same(accel[i], s->repeated[i]);
        s->repeated[i] = accel[i];
    }
    if (repeats) tick(&s->repeats, dt);
    else set_clock(&s->repeats, 0);
    if (!(moves && s->repeats.time > longest)) return 0;
    if (s->rate_age.time < s->repeats.time) s->rate_age = s->repeats;
    if (s->force_age.time < s->repeats.time) s->force_age = s->repeats;
    return 1;
}

/* Write this row's force and rate as far as they are believed, NaN where they are not; by how much a doubted
 * force jumped, m/s^2.  All six exactly 0 is a sensor that restarts; the same for long is one that is stuck. */
static real screen(baroarma_attitude *s, real C[3][3], real dt, const real accel[3], const real gyro[3],
                   real force[3], real rate[3])
{
    const int stuck = is_stuck(s, dt, accel, gyro), restarts = dot(accel, accel) <= 0 && dot(gyro, gyro) <= 0;
    const int there = is_sample(accel) && !restarts && !stuck;
    int turns = is_rate(gyro) && !restarts && !stuck, i;
    real world[3], jump;
    to_world(world, C, accel);
    jump = distance_squared(world, s->force);
    turns = turns && !is_doubted(&s->rate_doubt, gyro, distance_squared(gyro, s->rate), BAROARMA_RATE_JUMP);
    for (i = 0; i < 3; i++) {
        force[i] = there ? accel[i] : NO_SAMPLE;
        rate[i] = turns ? gyro[i] : NO_SAMPLE;
    }
    return there && is_doubted(&s->force_doubt, accel, jump, BAROARMA_FORCE_JUMP) ? SQRT(jump) : 0;
}

/* Turn by the trapezoid of two rates.  Between samples the last rate is held; the next one makes up for it. */
static void rotate(baroarma_attitude *s, real C[3][3], real dt, const real gyro[3])
{
    const int sampled = is_rate(gyro);
    const real late = sampled ? s->rate_age.time / 2 : 0;
    real angle[3];
    int i, j;
    for (j = 0; j < 3; j++) {
        const real next = sampled ? gyro[j] : s->rate[j];
        angle[j] = (1 - s->estimate[5 + j])
            * ((s->rate[j] - s->estimate[2 + j]) * dt + (next - s->rate[j]) * late);
        s->rate[j] = next;
    }
    if (sampled) {
        if (s->rate_age.time > BAROARMA_BLIND_TURN) s->unsure = 1;
        s->tilt_variance += gap_variance(s->gyro_noise, BAROARMA_TURN_BEND, s->rate_age.time);
        set_clock(&s->rate_age, 0);
    }
    turn(s->q, angle);
    fill_rotation(C, s->q);
    for (i = 0; i < 2; i++) {
        for (j = 0; j < 3; j++) {
            s->flow[i][j] -= C[i][j] * dt;
            s->flow[i][3 + j] -= C[i][j] * angle[j];
        }
    }
    if (dt > 0) s->tilt_variance += square(BAROARMA_RATE_ERROR) * BAROARMA_PERSISTENCE * dot(angle, angle) / dt;
}

/* Add the trapezoid of two world forces to the velocity; a missing one is held, but not for long. */
static void accelerate(baroarma_attitude *s, real C[3][3], real dt, const real accel[3], int believed)
{
    const int sampled = believed && is_sample(accel), known = s->force_age.time <= BAROARMA_LONGEST_HOLD;
    const real late = sampled ? s->force_age.time / 2 : 0;
    real force[3], by[3];
    int i;
    to_world(force, C, accel);
    for (i = 0; i < 3; i++) by[i] = s->force[i] * dt + (sampled ? (force[i] - s->force[i]) * late : 0);
    if (known) {
        for (i = 0; i < 2; i++) s->estimate[i] += by[i];
        s->push += by[2];
        for (i = 0; i < 6; i++) {
            s->flow[2][i] += by[2] * s->flow[1][i];
            s->flow[3][i] -= by[2] * s->flow[0][i];
        }
        if (sampled) {
            s->velocity_variance += gap_variance(s->accel_noise, BAROARMA_PUSH_BEND, s->force_age.time);
        }
        by[2] -= s->gravity * dt;
        if (dt > 0) {
            s->velocity_variance += square(BAROARMA_FORCE_ERROR) * BAROARMA_PERSISTENCE * dot(by, by) / dt;
        }
    } else {
        s->velocity_variance += square(BAROARMA_UNSEEN_WALK) * dt;
    }
    if (!sampled) return;
    for (i = 0; i < 3; i++) s->force[i] = force[i];
    set_clock(&s->force_age, 0);
}

/* Integrate the velocity and its errors, for their means. */
static void travel(baroarma_attitude *s, real dt)
{
    int i, j;
    s->double_push += s->push * dt;
    for (i = 0; i < 2; i++) {
        s->way[i] += s->estimate[i] * dt;
        for (j = 0; j < 6; j++) s->flow[4 + i][j] += s->flow[2 + i][j] * dt;
    }
}

/* Of "the mean velocity was 0": 2 sd^2 time / T, in a ride more by its square. */
static real velocity_variance(const baroarma_attitude *s)
{
    const real T = s->age.time, speed = HYPOT(s->way[0], s->way[1]) / T;
    const real variance = square(BAROARMA_VELOCITY_SD), own = (s->P[2][2] + s->P[3][3]) / 2;
    const real ride = speed / (BAROARMA_UNUSUAL * SQRT(variance + own));
    return 2 * variance * BAROARMA_VELOCITY_TIME / T * (ride > 1 ? square(ride) : 1);
}

/* F's first four rows of the interval that ends now; the others are the identity's. */
static void fill_transition(const baroarma_attitude *s, real F[4][ERRORS])
{
    int i, j;
    for (i = 0; i < 4; i++) {
        for (j = 0; j < ERRORS; j++) F[i][j] = j < 4 ? (real)(i == j) : s->flow[i][j - 4];
    }
    F[2][1] = s->push;
    F[3][0] = -s->push;
}

/* Row c of H: what the errors at the start do to the mean velocity. */
static void fill_mean(const baroarma_attitude *s, int c, real h[ERRORS])
{
    int j;
    for (j = 0; j < ERRORS; j++) h[j] = j < 4 ? 0 : s->flow[4 + c][j - 4] / s->age.time;
    h[1 - c] = (c == 0 ? s->double_push : -s->double_push) / s->age.time;
    h[2 + c] = 1;
}

/* One scalar measurement. */
static void hear(real x[ERRORS], real P[ERRORS][ERRORS], const real h[ERRORS], real z, real r)
{
    real row[ERRORS], variance = r;
    int i, j;
    for (i = 0; i < ERRORS; i++) {
        row[i] = 0;
        for (j = 0; j < ERRORS; j++) row[i] += P[i][j] * h[j];
        variance += h[i] * row[i];
        z -= h[i] * x[i];
    }
    for (i = 0; i < ERRORS; i++) {
        x[i] += row[i] * z / variance;
        for (j = 0; j < ERRORS; j++) P[i][j] -= row[i] * row[j] / variance;
    }
}

/* x = F x,  P = F P F' + Q. */
static void lead_on(const baroarma_attitude *s, real x[ERRORS], real P[ERRORS][ERRORS])
{
    real F[4][ERRORS], FP[4][ERRORS] = {{0}}, Fx[4] = {0};
    int i, j, k;
    fill_transition(s, F);
    for (i = 0; i < 4; i++) {
        for (k = 0; k < ERRORS; k++) {
            Fx[i] += F[i][k] * x[k];
            for (j = 0; j < ERRORS; j++) FP[i][j] += F[i][k] * P[k][j];
        }
    }
    for (i = 0; i < 4; i++) {
        x[i] = Fx[i];
        for (j = 4; j < ERRORS; j++) P[i][j] = P[j][i] = FP[i][j];
        for (j = 0; j < 4; j++) {
            P[i][j] = 0;
            for (k = 0; k < ERRORS; k++) P[i][j] += FP[i][k] * F[j][k];
        }
        P[i][i] += i < 2 ? s->tilt_variance : s->velocity_variance;
    }
    for (i = 4; i < 7; i++) P[i][i] += square(BAROARMA_BIAS_WALK) * s->age.time;
}

/* Take "the mean velocity was 0" and fold the errors found into the estimates. */
static void level(baroarma_attitude *s, real C[3][3])
{
    const real r = velocity_variance(s);
    real h[2][ERRORS], x[ERRORS] = {0}, tilt[3] = {0}, angle[3];
    int i;
    for (i = 0; i < 2; i++) fill_mean(s, i, h[i]);
    for (i = 0; i < 2; i++) hear(x, s->P, h[i], -s->way[i] / s->age.time, r);
    lead_on(s, x, s->P);
    for (i = 0; i < 8; i++) s->estimate[i] += x[2 + i];
    for (i = 0; i < 2; i++) tilt[i] = x[i];
    to_body(angle, C, tilt);
    turn(s->q, angle);
    normalise(s->q, 4);
    fill_rotation(C, s->q);
    begin(s);
}

/* Go on from a tilt taken anew with this row's samples; without one, as if at rest. */
static void restart(baroarma_attitude *s, real C[3][3], const real accel[3], const real gyro[3])
{
    int i;
    for (i = 0; i < 3; i++) {
        s->rate[i] = is_rate(gyro) ? gyro[i] : s->estimate[2 + i];
        s->force[i] = i == 2 ? s->gravity : 0;
    }
    if (is_sample(accel)) to_world(s->force, C, accel);
    set_clock(&s->rate_age, 0);
    set_clock(&s->force_age, 0);
}

/* Take the tilt from a specific force, body axes; 0 in free fall, which has no vertical. */
static int level_anew(baroarma_attitude *s, real C[3][3], const real force[3], real sd)
{
    int i, j;
    if (SQRT(dot(force, force)) < s->gravity / 2) return 0;
    fill_level(s->q, force);
    fill_rotation(C, s->q);
    for (i = 0; i < 4; i++) {
        for (j = 0; j < ERRORS; j++) {
            s->P[i][j] = 0;
            s->P[j][i] = 0;
        }
    }
    for (i = 0; i < 2; i++) {
        s->P[i][i] = square(sd);
        s->P[2 + i][2 + i] = square(BAROARMA_RIDE_SD);
        s->estimate[i] = 0;
    }
    begin(s);
    return 1;
}

/* Whether the tilt must be wrong: nobody is that fast, or the mean force points down. */
static int is_lost(const baroarma_attitude *s)
{
    return HYPOT(s->estimate[0], s->estimate[1]) > BAROARMA_TOP_SPEED || s->push < 0;
}

/* Level; a tilt that is doubtful or must be wrong is taken anew from the interval's mean force. */
static void end_interval(baroarma_attitude *s, real C[3][3], const real accel[3], const real gyro[3])
{
    const real T = s->age.time;
    const real mean[3] = {(s->estimate[0] - s->start[0]) / T, (s->estimate[1] - s->start[1]) / T, s->push / T};
    real force[3];
    to_body(force, C, mean);
    if ((s->unsure || is_lost(s)) && level_anew(s, C, force, BAROARMA_LEVELLED_SD)) {
        restart(s, C, accel, gyro);
        s->unsure = 0;
    } else {
        level(s, C);
    }
}

/* Write the vertical `latency` ahead. */
static void fill_ahead(const baroarma_attitude *s, real up[3], real C[3][3])
{
    const real *now = C[2];
    real angle[3];
    int i;
    for (i = 0; i < 3; i++) {
        angle[i] = BAROARMA_LATENCY * (s->rate[i] - s->estimate[2 + i]);
        up[i] = now[i];
    }
    if (!(BAROARMA_LATENCY > 0)) return;
    up[0] += angle[2] * now[1] - angle[1] * now[2];
    up[1] += angle[0] * now[2] - angle[2] * now[0];
    up[2] += angle[1] * now[0] - angle[0] * now[1];
    normalise(up, 3);
}

/* The vertical acceleration, m/s^2; NaN without an accelerometer sample.  `up` becomes the vertical.  What the
 * accelerometer feels beside gravity is projected on the vertical ahead: gravity arrives as late as the rate. */
static real attitude_step(baroarma_attitude *s, real dt, const real accel[3], const real gyro[3], real up[3])
{
    real C[3][3], felt[3], force[3], rate[3], jump;
    int i;
    tick(&s->rate_age, dt);
    tick(&s->force_age, dt);
    tick(&s->age, dt);
    fill_rotation(C, s->q);
    jump = screen(s, C, dt, accel, gyro, force, rate);
    if (s->rate_age.time <= BAROARMA_LONGEST_HOLD) {
        rotate(s, C, dt, rate);
        if (jump > 0) s->velocity_variance += square(jump * dt); /* passed over, but it may have been true */
        accelerate(s, C, dt, force, !(jump > 0));
        travel(s, dt);
        if (s->age.time > 0
            && s->age.time > BAROARMA_INTERVAL / (s->unsure ? 2 : 1) - BAROARMA_ROUNDING) {
            end_interval(s, C, force, rate);
        }
    } else if (is_sample(force) && level_anew(s, C, force, BAROARMA_LEVELLING_SD)) {
        restart(s, C, force, rate);
        s->unsure = 1;
    }
    fill_ahead(s, up, C);
    for (i = 0; i < 3; i++) felt[i] = force[i] - s->gravity * C[2][i];
    return is_sample(force) ? dot(felt, up) : NO_SAMPLE;
}

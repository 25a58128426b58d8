/* ---- this height filter neither looks back on the alignment nor asks whether the IMU feels anything -------- */

static void early_start(baroarma_early *s)
{
    s->nothing = 0;
}

static void early_take(baroarma_early *s, real dt, real altitude)
{
    (void)s;
    (void)dt;
    (void)altitude;
}

static void height_look_back(baroarma_height *s, baroarma_early *early, real dt)
{
    (void)s;
    (void)early;
    (void)dt;
}

static void stillness_start(baroarma_stillness *s, const baroarma_rest *rest)
{
    (void)rest;
    s->nothing = 0;
}

static real stillness_step(baroarma_stillness *s, real dt, const real accel[3], const real gyro[3])
{
    (void)s;
    (void)dt;
    (void)accel;
    (void)gyro;
    return NO_SAMPLE;
}

static int is_still(const baroarma_stillness *s)
{
    (void)s;
    return 0;
}

/* exp(-rate dt), cheaply where the rate is 0. */
static real decay(real rate, real dt)
{
    return rate > 0 ? EXP(-rate * dt) : 1;
}

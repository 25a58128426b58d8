/* ---- attitude from a vertical ------------------------------------------------------------------------------ */

/* The shortest rotation that has this vertical, of any length; upside down it is a turn about x. */
static void fill_level(real q[4], const real up[3])
{
    const real horizontal = HYPOT(up[0], up[1]), half = ATAN2(horizontal, up[2]) / 2;
    q[0] = SIN(half);
    q[1] = 0;
    q[2] = 0;
    q[3] = COS(half);
    if (horizontal > 0) {
        q[0] = SIN(half) * up[1] / horizontal;
        q[1] = -SIN(half) * up[0] / horizontal;
    }
}

/* ---- height in two numbers --------------------------------------------------------------------------------- */

/* Add to a height, m, what is small against it.  The second number keeps what the first is too coarse for:
 * high up, a float would not notice a slow climb at all. */
static void climb(real *height, real *low, real by)
{
    const real added = by - *low, sum = *height + added;
    *low = (sum - *height) - added;
    *height = sum;
}

#include "baroarma.h"

#include <math.h>
#include <stddef.h>

/* ---- numbers: float or double, as the configuration says ------------------------------------------------ */

typedef baroarma_real real;

#if BAROARMA_FLOAT
#define ATAN2 atan2f
#define COS cosf
#define EXP expf
#define EXPM1 expm1f
#define FABS fabsf
#define HYPOT hypotf
#define LOG logf
#define LOG1P log1pf
#define SIN sinf
#define SQRT sqrtf
#else
#define ATAN2 atan2
#define COS cos
#define EXP exp
#define EXPM1 expm1
#define FABS fabs
#define HYPOT hypot
#define LOG log
#define LOG1P log1p
#define SIN sin
#define SQRT sqrt
#endif

static const real NO_SAMPLE = (real)NAN;

static real square(real a)
{
    return a * a;
}

static real dot(const real a[3], const real b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* A variance that rounding has made negative counts as 0. */
static real root_of(real variance)
{
    return variance < 0 ? 0 : SQRT(variance);
}

static void normalise(real *v, int n)
{
    real sum = 0;
    int i;
    for (i = 0; i < n; i++) sum += square(v[i]);
    sum = SQRT(sum);
    for (i = 0; i < n; i++) v[i] /= sum;
}

/* Whether a specific force is there, and can be. */
static int is_sample(const real v[3])
{
    return dot(v, v) < square(BAROARMA_MOST_FORCE);
}

/* Whether an angular rate is there, and can be. */
static int is_rate(const real v[3])
{
    return dot(v, v) < square(BAROARMA_MOST_RATE);
}

/* Sum up time, s.  The second number keeps what a float is too coarse for, so that no decision falls a sample
 * later than it should; a double adds up as Python does. */
static void tick(baroarma_clock *clock, real dt)
{
    const real added = dt - clock->low, sum = clock->time + added;
    clock->low = BAROARMA_FLOAT ? (sum - clock->time) - added : 0;
    clock->time = sum;
}

static void set_clock(baroarma_clock *clock, real time)
{
    clock->time = time;
    clock->low = 0;
}

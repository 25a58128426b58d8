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

typedef struct {
    baroarma_real dt;                                  /* interval for which these hold, s */
    baroarma_real F[BAROARMA_STATES][BAROARMA_STATES]; /* transition */
    baroarma_real B[BAROARMA_STATES];                  /* what an acceleration does to the state */
    baroarma_real wander[BAROARMA_STATES];             /* process noise without the acceleration's: diagonal */
} baroarma_model;

typedef struct {
    baroarma_real x[BAROARMA_STATES];                  /* height, m, velocity, m/s, and what else is unknown */
    baroarma_real low;                                 /* what x[0] is too coarse for, m */
    baroarma_real P[BAROARMA_STATES][BAROARMA_STATES]; /* covariance */
} baroarma_filter;


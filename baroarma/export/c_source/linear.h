typedef struct {
    baroarma_real x[BAROARMA_STATES];                    /* height, m, velocity, m/s, and what else is unknown */
    baroarma_real P[BAROARMA_STATES][BAROARMA_STATES];   /* its covariance */
    baroarma_real low;                                   /* what x[0] is too coarse for, m */
    baroarma_real dt;                                    /* interval for which the next three hold, s */
    baroarma_real F[BAROARMA_STATES][BAROARMA_STATES];   /* transition */
    baroarma_real wander[BAROARMA_STATES];               /* process noise without the acceleration's: diagonal */
    baroarma_real acceleration_sd;                       /* of one acceleration sample, m/s^2 */
    int started;
    baroarma_drive drive;
} baroarma_height;


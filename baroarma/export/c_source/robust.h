typedef struct {
    baroarma_real patience;                 /* how many samples may be passed over */
    baroarma_real sample[3];                /* the last that was */
    int open;                               /* whether it is to be seen again */
} baroarma_suspect;

typedef struct {
    baroarma_real q[4];                     /* body -> world, scalar last */
    baroarma_real estimate[8];              /* horizontal velocity, m/s, gyro bias, rad/s, gyro scale */
    baroarma_real rate[3], force[3];        /* the last ones, rad/s, body axes, and m/s^2, world axes */
    baroarma_clock rate_age, force_age;     /* of these */
    baroarma_suspect rate_doubt, force_doubt; /* of samples that jump */
    int noisy;                              /* whether the sensor showed noise at rest */
    baroarma_clock repeats;                 /* since it has said the same */
    baroarma_real repeated[3];              /* the specific force that it said, m/s^2 */
    int unsure;                             /* whether the tilt is doubtful */
    baroarma_clock age;                     /* since the last levelling */
    baroarma_real flow[6][6];               /* what bias and scale have done to tilt, velocity, and its integral */
    baroarma_real push, double_push;        /* first and second integral of the vertical force */
    baroarma_real tilt_variance, velocity_variance; /* process noise of each axis */
    baroarma_real way[2], start[2];         /* integral of the velocity, m; the velocity at the start, m/s */
    baroarma_real P[10][10];                /* covariance of tilt, velocity, bias, scale */
    baroarma_real gravity;                  /* modulus of the specific force at rest, m/s^2 */
    baroarma_real gyro_noise, accel_noise;  /* variances of one sample */
} baroarma_attitude;


typedef struct {
    baroarma_real rate[3]; /* angular rate in use, rad/s */
    baroarma_real bias[3]; /* the gyro's, from the alignment, rad/s */
    baroarma_real age;     /* time since its sample, s */
} baroarma_rate;


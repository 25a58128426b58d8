typedef struct {
    baroarma_real x[7];    /* quaternion body -> world, scalar last, and accelerometer bias, m/s^2 */
    baroarma_real P[7][7]; /* its covariance */
    baroarma_real gravity; /* modulus of the specific force at rest, m/s^2 */
    baroarma_rate held;
} baroarma_attitude;


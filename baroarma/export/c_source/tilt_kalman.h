typedef struct {
    baroarma_real up[3];       /* the vertical in body axes */
    baroarma_real P[3][3];     /* its covariance */
    baroarma_real external[3]; /* the last acceleration without gravity, body axes, m/s^2 */
    baroarma_real gravity;     /* modulus of the specific force at rest, m/s^2 */
    baroarma_rate held;
} baroarma_attitude;


typedef struct {
    baroarma_real reference[3];          /* mean specific force of the quiet period, m/s^2 */
    baroarma_real force[3], rate[3];     /* short means, m/s^2 and rad/s */
    baroarma_real last[3];               /* specific force, m/s^2 */
    baroarma_real bias[3];               /* the gyro's, rad/s */
    baroarma_real gravity;               /* modulus of the specific force at rest, m/s^2 */
    baroarma_real accel_sd, gyro_sd;     /* of one sample and axis, m/s^2 and rad/s */
    baroarma_real shaking;               /* variance of one specific force, from successive samples, (m/s^2)^2 */
    baroarma_clock age, silence;         /* of the quiet period; since the last sample */
    int begun;                           /* the period has a sample */
} baroarma_stillness;


typedef struct {
    baroarma_real before; /* acceleration before the last, m/s^2 */
    baroarma_real last;   /* acceleration, m/s^2 */
    baroarma_real change; /* from the one before to it, m/s^2 */
    int quiet;            /* samples in a row that are nearly 0 */
} baroarma_drive;


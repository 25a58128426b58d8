/* What the alignment's second has room for.  Rows without an altitude are kept one by one where there is room
 * beside the altitudes to come, and else as evenly spaced, which an IMU's clock is to some microseconds. */
#ifndef BAROARMA_EARLY_ROWS
#define BAROARMA_EARLY_ROWS BAROARMA_EARLY_ALTITUDES
#endif

typedef struct {
    int rows;               /* of the IMU, the last of which had the altitude */
    baroarma_real span;     /* time that they took, s */
    baroarma_real altitude; /* m; NaN: none */
} baroarma_early_rows;

typedef struct {
    int count, altitudes; /* entries that are complete; altitudes in them */
    baroarma_early_rows entries[BAROARMA_EARLY_ROWS + 1];
} baroarma_early;


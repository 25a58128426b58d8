#define BAROARMA_FILTERS 4

typedef struct {
    baroarma_clock since;   /* since altitudes are rejected */
    int count;              /* how many were */
    baroarma_real first;    /* how far they were off at first, on average, m */
    baroarma_real late;     /* ... and of late, m */
    baroarma_real jump;     /* that the next prediction is to allow, m; negative: of the barometer's offset */
    baroarma_real sum;      /* recent innovations, in standard deviations */
} baroarma_doubt;

typedef struct {
    baroarma_model model;
    baroarma_filter filters[BAROARMA_FILTERS]; /* the first is the filter while there is no fork */
    baroarma_doubt doubts[BAROARMA_FILTERS];
    int forked, older, on_floor;   /* a rest is considered; the older of the recent; a floor has been taken */
    baroarma_real odds;            /* log-odds of rest */
    int refuted;                   /* they were below -SURE, and have not been above SURE since */
    baroarma_clock age, since;     /* of the fork; since a recent filter began anew */
    baroarma_real silence;         /* time since the last altitude, s */
    baroarma_real altitude;        /* the last one, m */
    int repeats;                   /* how many times in a row it has come again */
    baroarma_real sway;            /* variance of the velocity of what rests, (m/s)^2 */
    baroarma_real anchor[3], away; /* the vertical of the last rest; the greatest 1 - cos since */
    baroarma_real acceleration_sd; /* of one sample, m/s^2 */
    baroarma_real bias_sd;         /* by how much a turn changes the accelerometer's bias, m/s^2 */
    int started;
    baroarma_drive drive;
} baroarma_height;


typedef struct {
    baroarma_real x[2];                    /* height, m, and velocity, m/s */
    baroarma_real low;                     /* what x[0] is too coarse for, m */
    baroarma_real P[5][5];                 /* of their errors, Gauss-Markov noise, drift, the sample's noise */
    baroarma_real sample, since;           /* last altitude, m; time since one was used, s */
    int unused, started;
    baroarma_drive drive;
} baroarma_height;


typedef struct {
    baroarma_real recent[BAROARMA_AVERAGE]; /* the last new altitudes, m, oldest first */
    int count;
    baroarma_real delay; /* of the whitening filter, m */
} baroarma_conditioning;


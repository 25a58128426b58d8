typedef struct {
    char nothing; /* C has no empty structure */
} baroarma_conditioning;


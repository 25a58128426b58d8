typedef struct {
    char nothing; /* C has no empty structure */
} baroarma_early;

typedef struct {
    char nothing;
} baroarma_stillness;


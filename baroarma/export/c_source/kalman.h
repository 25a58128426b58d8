typedef struct {
    baroarma_model model;
    baroarma_filter filter;
    int started;
    baroarma_drive drive;
} baroarma_height;


"""File formats: files in, recordings out."""

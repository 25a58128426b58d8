"""`python -m baroarma`: the command line."""

from baroarma.cli import entry_point

if __name__ == "__main__":
    entry_point()

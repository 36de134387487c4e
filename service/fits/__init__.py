"""Laws, surrogates and constants of materials out of results, on the command line; each module offers ``COMMANDS``."""

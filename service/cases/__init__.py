"""Published problems, computed and compared on the command line: ``whipple validate``."""

"""What ships: materials, laws and scenarios, on the command line and over HTTP."""

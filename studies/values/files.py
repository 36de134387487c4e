"""Names of the files that a run and a sweep leave, for whoever writes, moves or serves them."""

ANSWER = "result.json"  # of a run: what was measured, or why nothing was
STATE = "state.npz"  # its final state
FILM = "film.npz"  # its frames
CUBE, REPORT_HTML, REPORT_JSON = OF_A_SWEEP = ("cube.nc", "report.html", "report.json")

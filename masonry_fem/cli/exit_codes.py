"""Exit code: how a command tells a script what came out."""

BAD_INPUT = 1
INTERRUPTED = 130
PIPE_CLOSED = 141
COLLAPSE_CODES = {
    "bracketed": 0,
    "unlimited": 0,
    "undecided": 2,
    "falls at the start": 3,
    "interrupted": INTERRUPTED,
}
THRESHOLD_CODES = {
    "bracketed": 0,
    "undecided": 2,
    "stands at both ends": 2,
    "falls at both ends": 3,
    "interrupted": INTERRUPTED,
}
EXIT_CODES = {"equilibrium": 0, "finished": 0, "no_convergence": 2, "no_equilibrium": 3}
WORDS = (
    "Exit codes: 0 equilibrium or finished (collapse, threshold: bracketed; limit: the loads can be "
    "carried), 1 bad input, or a file that cannot be read or written, 2 no convergence (collapse: undecided; "
    "threshold: undecided, or it stands at both ends; --refine-to: not reached; study: no cell solved, "
    "no run decided), 3 no equilibrium (collapse: falls at the start; threshold: falls at both ends), "
    "129, 130, 143 ended by SIGHUP, Ctrl-C, SIGTERM, with what was written so far readable, "
    "141 the reader of the output closed it."
)

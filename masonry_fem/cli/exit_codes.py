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
EXIT_CODES = {"equilibrium": 0, "finished": 0, "no_convergence": 2, "no_equilibrium": 3}

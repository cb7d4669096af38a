"""Parts of the methods: sweeps, Newton systems, colouring, homotopies."""

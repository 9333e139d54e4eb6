"""One file per figure, one style; a figure is drawn from tables and nothing else."""

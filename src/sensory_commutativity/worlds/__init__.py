"""Where the experiment is played. Nothing outside this package imports a physics engine."""

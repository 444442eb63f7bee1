"""Export of plans as files for other programs: motions, curves, obstacles and arms."""

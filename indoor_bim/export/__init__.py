"""Writers of the building model: each reads the model and nothing else."""

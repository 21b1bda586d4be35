"""Project files of jobs, machines and simulations (TOML)."""
